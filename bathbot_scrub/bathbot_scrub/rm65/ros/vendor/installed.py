"""The one place that knows that the vendor's messages may not be installed."""

from typing import Any

from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.rm65.driver import ArmDriver


def vendor_topics(node: Any, driver: ArmDriver) -> Any:
    """The vendor driver's topics on a node, as `VendorTopics`.

    Raises:
        ArmSettingsError: Its messages are not installed.
    """
    try:
        from bathbot_scrub.rm65.ros.vendor.vendor_topics_node import VendorTopics
    except ModuleNotFoundError as error:
        raise ArmSettingsError(
            f"vendor_topics is true, but there is no module {error.name}; build rm_ros_interfaces of the "
            "vendor's ros2_rm_robot and source it"
        ) from error
    return VendorTopics(node, driver)
