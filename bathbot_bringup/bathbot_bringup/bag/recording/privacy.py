"""What may be recorded: named privacy profiles, each an allow-list of topics with type and size.

Whoever is bathed is undressed. A picture, a depth picture and a cloud of surface points all show that
person, so a profile that has them asks for consent, and one that has not looks into every message.
"""

import datetime
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

import yaml
from bathbot_depthcorr.bounded_files import read_yaml

from bathbot_bringup.bag.recording.content import KNOWN, Bounds
from bathbot_bringup.errors import InputError, SettingsError

_ANY = "*"
_TEXT, _ITEMS = 120, 64  # bounds where a profile names none


PICTURE_TYPES = frozenset(
    {
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/PointCloud",
        "sensor_msgs/msg/PointCloud2",
        "stereo_msgs/msg/DisparityImage",
        "realsense2_camera_msgs/msg/RGBD",
    }
)


class Entry(NamedTuple):
    """What a profile says of some topics."""

    pattern: str  # of resolved topic names; `*` also matches `/`, so that `*/wrench` fits any namespace
    message_type: str
    bounds: Bounds


class Consent(NamedTuple):
    """Who agreed to be recorded, when, and to what end."""

    who: str = ""
    when: str = ""  # YYYY-MM-DD
    why: str = ""

    def trouble(self) -> str:
        """What is missing or wrong; empty when nothing is."""
        missing = [name for name, said in self._asdict().items() if not said.strip()]
        if missing:
            return f"it does not say {' and '.join(missing)}"
        try:
            day = datetime.date.fromisoformat(self.when.strip())
        except ValueError:
            return f"when is {self.when!r}, no date such as 2026-01-31"
        return f"when is {day}, a day to come" if day > datetime.date.today() else ""


@dataclass(frozen=True, slots=True)
class PrivacyProfile:
    """What one profile lets through.

    Attributes:
        name: Name of the profile.
        about: One sentence for a person.
        pictures: True when pictures and point clouds may be recorded.
        entries: The allow-list.
    """

    name: str
    about: str
    pictures: bool
    entries: tuple[Entry, ...]

    def bounds(self, topic: str, message_type: str) -> Bounds | None:
        """What messages of a topic and a type must keep to; None when they may not be recorded.

        Where an entry names the topic's type, no other type of it passes, whatever stands beside it.
        """
        if not self.pictures and message_type in PICTURE_TYPES:
            return None
        named = [entry for entry in self.entries if fnmatchcase(topic, entry.pattern)]
        typed = [entry for entry in named if entry.message_type != _ANY]
        fitting = [entry for entry in typed or named if entry.message_type in (message_type, _ANY)]
        return fitting[0].bounds if fitting else None

    def refusal(self, bounds: Bounds, size: int, decode: Callable[[], Any]) -> str:
        """Why a message may not be recorded; empty when it may.

        Args:
            bounds: Of its topic and type.
            size: Of its bytes.
            decode: Gives its content, which is looked into where the profile has no pictures.
        """
        if size > bounds.size:
            return f"{size} bytes, more than {bounds.size}"
        return "" if self.pictures else bounds.refusal(decode())

    def check_consent(self, consent: Consent) -> None:
        """Refuse to record a person's pictures without a word on who agreed.

        Raises:
            SettingsError: When the profile has pictures and the consent is not whole.
        """
        if self.pictures and (trouble := consent.trouble()):
            raise SettingsError(
                f"profile {self.name!r} records pictures and needs consent: {trouble}; say for instance "
                "who 'A. Example', when 2026-01-31, why 'gait study, kept one year'"
            )


def load_profiles(file: Path) -> dict[str, PrivacyProfile]:
    """Read the profiles of a YAML file.

    Raises:
        InputError: When the file is missing or is not a file of profiles.
    """
    try:
        document = read_yaml(file)
        return {
            name: PrivacyProfile(
                name, str(said["about"]), said["pictures"] is True, tuple(_entries(document, name))
            )
            for name, said in document.items()
        }
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"cannot read privacy profiles {file}; config/privacy_profiles.yaml is an example"
        ) from error
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise InputError(
            f"{file} is no file of privacy profiles; each needs about, pictures and topics, each of those "
            "topic, type and bytes"
        ) from error


def _entries(document: Mapping[str, Any], name: str) -> list[Entry]:
    said = document[name]
    own = [
        Entry(
            str(one["topic"]),
            str(one["type"]),
            Bounds(
                int(one["bytes"]),
                int(one.get("text", _TEXT)),
                int(one.get("items", _ITEMS)),
                _known(one.get("known", "")),
            ),
        )
        for one in said["topics"]
    ]
    return own + (_entries(document, said["include"]) if "include" in said else [])


def _known(name: str) -> str:
    if name not in ("", *KNOWN):
        raise ValueError(f"known is {name!r}; there are {', '.join(KNOWN)}")
    return name


def find_profile(file: Path, name: str) -> PrivacyProfile:
    """Read one profile by name.

    Raises:
        InputError: When the file is missing or is not a file of profiles.
        SettingsError: When no profile has this name.
    """
    profiles = load_profiles(file)
    if name not in profiles:
        raise SettingsError(f"no privacy profile is named {name!r}; there are {', '.join(sorted(profiles))}")
    return profiles[name]
