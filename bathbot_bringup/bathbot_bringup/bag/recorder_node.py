"""Node `recorder`: the topics of a privacy profile -> a rosbag2 MCAP bag, bytes as they came."""

from collections.abc import Callable
from pathlib import Path

from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from bathbot_bringup.bag.privacy import PrivacyProfile, find_profile
from bathbot_bringup.bag.recorder import Recorder, Topic, refuse_existing
from bathbot_bringup.bag.recorder_settings import RecorderSettings
from bathbot_bringup.errors import BringupError, SettingsError
from bathbot_bringup.graph.installation import config_file
from bathbot_bringup.graph.message_types import message_class

_FOREVER = QosTime(2147483647, 4294967295)
_DEPTH = 100


def subscription_qos(offered: list[QoSProfile]) -> QoSProfile:
    """Choose a profile that hears every publisher: the weakest of what they offer."""
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    latched = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=_DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def stored_qos(offered: QoSProfile) -> Qos:
    """Write down an offered profile; discovery does not tell its history, so KEEP_LAST is noted."""
    return Qos(
        QosHistory.KEEP_LAST,
        offered.depth or 10,
        QosReliability[offered.reliability.name],
        QosDurability[offered.durability.name],
        _FOREVER,
        _FOREVER,
        QosLiveliness.AUTOMATIC,
        _FOREVER,
        False,
    )


class RecorderNode(StageNode):
    """Looks for topics that the profile allows and writes all their messages, unread."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("recorder", RecorderSettings)

    def setup(self, settings: RecorderSettings) -> None:
        """Check what can be checked before the first message."""
        if not settings.bag:
            raise SettingsError(
                "bag is empty, so there is nowhere to record to; give a name, such as bag:=my_run"
            )
        file = (
            Path(settings.profiles)
            if settings.profiles
            else config_file("bathbot_bringup", "privacy_profiles.yaml")
        )
        self._profile: PrivacyProfile = find_profile(file, settings.profile)
        self._profile.check_consent(settings.consent)
        refuse_existing(Path(settings.bag))
        self._settings = settings

    def start(self) -> None:
        """Open the bag and look for topics."""
        notes = {"privacy_profile": self._profile.name, "consent": self._settings.consent}
        self._recorder = Recorder(Path(self._settings.bag), notes, self._settings.queue_megabytes << 20)
        self.at_end(self._close)
        self._heard: set[str] = set()
        self._unknown: set[str] = set()
        self.every(self._settings.search_period, self._find_topics)
        self._find_topics()

    def _close(self) -> None:
        summary = self._recorder.close()
        self.get_logger().info(
            f"wrote {summary.messages} messages to {summary.path}, {summary.dropped} dropped"
        )

    def _find_topics(self) -> None:
        for name, types in self.get_topic_names_and_types():
            if name not in self._heard and any(self._profile.allows(name, kind) for kind in types):
                self._subscribe(name, types[0])
        self._report()

    def _subscribe(self, name: str, message_type: str) -> None:
        offered = [info.qos_profile for info in self.get_publishers_info_by_topic(name)]
        if not offered or message_type in self._unknown:
            return
        try:
            if not self._profile.allows(name, message_type) or not Recorder.knows(message_type):
                raise BringupError(f"{name} of type {message_type} is not recorded; install its definition")
            kind = message_class(message_type)
        except BringupError as error:
            self._unknown.add(message_type)
            self.get_logger().warning(str(error))
            return
        self._recorder.add(Topic(name, message_type, [stored_qos(profile) for profile in offered]))
        self._heard.add(name)
        self.listen(kind, name, self._writer_of(name), subscription_qos(offered), raw=True)

    def _writer_of(self, name: str) -> Callable[[bytes], None]:
        clock, put = self.get_clock(), self._recorder.put
        return lambda data: put(name, clock.now().nanoseconds, data)

    def _report(self) -> None:
        recorder = self._recorder
        verdict, heard = recorder.verdict(self._profile.name), len(self._heard)
        self.report(
            verdict.level.value, verdict.message, topics=heard, messages=recorder.messages,
            dropped=recorder.dropped,
        )  # fmt: skip


def main() -> None:
    """Run the node."""
    run(RecorderNode)


if __name__ == "__main__":
    main()
