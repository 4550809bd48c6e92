"""The quality of service of what is recorded: how it is heard, and how it was offered."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

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
