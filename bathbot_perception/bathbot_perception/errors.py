"""What can go wrong between a picture and its skin regions."""

from bathbot_depthcorr.errors import BathbotError


class PerceptionError(BathbotError):
    """Base of every error this package raises on purpose; its text fits on one line."""


class SettingsError(PerceptionError):
    """A parameter that no detector can work with."""


class PictureError(PerceptionError):
    """A picture or film that cannot be read, or not as colour."""


class AnnotationError(PerceptionError):
    """A PASCAL VOC file or folder that does not say what is in its pictures."""


class ModelError(PerceptionError):
    """A model file that is no skin detector of ours."""


class TrainingError(PerceptionError):
    """A training run that cannot go on."""
