"""Node `recorder`: the topics of a privacy profile -> a rosbag2 MCAP bag, bytes as they came."""

from pathlib import Path

from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.executors import SingleThreadedExecutor

from bathbot_bringup.bag.message_types import message_class
from bathbot_bringup.bag.recording.content import Bounds
from bathbot_bringup.bag.recording.hearing_node import Hearing
from bathbot_bringup.bag.recording.mcap_bag import Source, Topic, refuse_existing
from bathbot_bringup.bag.recording.privacy import Consent, PrivacyProfile, find_profile
from bathbot_bringup.bag.recording.recorder import Recorder
from bathbot_bringup.bag.recording.recorder_qos_node import stored_qos, subscription_qos
from bathbot_bringup.bag.recording.recorder_settings import RecorderSettings
from bathbot_bringup.errors import BringupError, SettingsError
from bathbot_bringup.graph.installation import config_file


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
        self._consent = Consent(settings.who, settings.when, settings.why)
        self._profile.check_consent(self._consent)
        refuse_existing(Path(settings.bag))
        self._settings = settings

    def start(self) -> None:
        """Open the bag and look for topics."""
        notes = {"privacy_profile": self._profile.name}
        if self._profile.pictures:
            notes |= {f"consent_{name}": said for name, said in self._consent._asdict().items()}
        self._recorder = Recorder(
            Path(self._settings.bag), self._profile, notes, self._settings.queue_megabytes << 20
        )
        self.at_end(self._close)
        self._hearing = Hearing(self, self._recorder)  # ends before the recorder does
        self._heard: set[Source] = set()
        self._unknown: set[Source] = set()
        self.every(self._settings.search_period, self._find_topics)
        self._find_topics()

    def _close(self) -> None:
        summary = self._recorder.close()
        self.get_logger().info(
            f"wrote {summary.messages} messages to {summary.path}, {summary.lost} lost, "
            f"{summary.refused} refused"
        )

    def _find_topics(self) -> None:
        for name, types in self.get_topic_names_and_types():
            for kind in types:
                source = Source(name, kind)
                bounds = self._profile.bounds(name, kind)
                if source not in self._heard and bounds is not None:
                    self._subscribe(source, bounds)
        self._report()

    def _subscribe(self, source: Source, bounds: Bounds) -> None:
        offers = self.get_publishers_info_by_topic(source.topic)
        offered = [offer.qos_profile for offer in offers if offer.topic_type == source.message_type]
        if not offered or source in self._unknown:
            return
        try:
            if any(heard.topic == source.topic for heard in self._heard):
                raise BringupError(
                    f"{source.topic} is offered with type {source.message_type}, too, which is not recorded"
                )
            if not Recorder.knows(source.message_type):
                raise BringupError(
                    f"{source.topic} of type {source.message_type} is not recorded; install its definition"
                )
            kind = message_class(source.message_type)
        except BringupError as error:
            self._unknown.add(source)
            self.get_logger().warning(str(error))
            return
        self._heard.add(source)
        self._recorder.add(Topic(source, [stored_qos(profile) for profile in offered]))
        self._hearing.add(source, kind, subscription_qos(offered), bounds.size)

    def _report(self) -> None:
        recorder = self._recorder
        verdict, heard = recorder.verdict(), len(self._heard)
        self.report(
            verdict.level.value, verdict.message, topics=heard, messages=recorder.messages,
            lost=recorder.lost, refused=recorder.refused,
        )  # fmt: skip


def main() -> None:
    """Run the node."""
    run(RecorderNode, executor=SingleThreadedExecutor)  # another takes messages that are heard by a thread


if __name__ == "__main__":
    main()
