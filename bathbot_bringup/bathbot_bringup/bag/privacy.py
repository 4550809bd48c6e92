"""What may be recorded: named privacy profiles, an allow-list of topics each.

Whoever is bathed is undressed. A picture, a depth picture and a cloud of surface points all
show that person, so no profile records them unless it says `images` and a consent is given.
"""

from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import yaml

from bathbot_bringup.errors import InputError, SettingsError

IMAGE_TYPES = frozenset(
    {
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/PointCloud",
        "sensor_msgs/msg/PointCloud2",
        "stereo_msgs/msg/DisparityImage",
        "realsense2_camera_msgs/msg/RGBD",
    }
)


@dataclass(frozen=True, slots=True)
class PrivacyProfile:
    """What one profile lets through.

    Attributes:
        name: Name of the profile.
        about: One sentence for a person.
        topics: Patterns of resolved topic names; `*` also matches `/`, so that `*/wrench` fits any namespace.
        images: True when pictures and point clouds may be recorded.
    """

    name: str
    about: str
    topics: tuple[str, ...]
    images: bool

    def allows(self, topic: str, message_type: str) -> bool:
        """Tell whether messages of this topic may be recorded."""
        if message_type in IMAGE_TYPES and not self.images:
            return False
        return any(fnmatchcase(topic, pattern) for pattern in self.topics)

    def check_consent(self, consent: str) -> None:
        """Refuse to record a person's pictures without a word on who agreed.

        Raises:
            SettingsError: When the profile records images and `consent` is empty.
        """
        if self.images and not consent.strip():
            raise SettingsError(
                f"profile {self.name!r} records pictures and needs consent, got {consent!r}; "
                "say who agreed and when, for instance consent:='A. Example, 2026-01-31, in writing'"
            )


def load_profiles(file: Path) -> dict[str, PrivacyProfile]:
    """Read the profiles of a YAML file.

    Raises:
        InputError: When the file is missing or is not a file of profiles.
    """
    try:
        document = yaml.safe_load(file.read_text(encoding="utf-8"))
        return {
            name: PrivacyProfile(
                name, str(entry["about"]), tuple(map(str, entry["topics"])), entry["images"] is True
            )
            for name, entry in document.items()
        }
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"cannot read privacy profiles {file}; config/privacy_profiles.yaml is an example"
        ) from error
    except (yaml.YAMLError, AttributeError, KeyError, TypeError) as error:
        raise InputError(
            f"{file} is no file of privacy profiles; each needs about, topics and images"
        ) from error


def find_profile(file: Path, name: str) -> PrivacyProfile:
    """Read one profile by name.

    Raises:
        SettingsError: On an unknown name; the message lists the names that exist.
        InputError: When the file cannot be read.
    """
    profiles = load_profiles(file)
    if name not in profiles:
        raise SettingsError(f"no privacy profile is named {name!r}; there are {', '.join(sorted(profiles))}")
    return profiles[name]
