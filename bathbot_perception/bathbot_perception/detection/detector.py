"""The skin detector at run time: a colour picture in, skin regions out (section 2.1.1)."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import onnxruntime
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.letterbox import STRIDE, Letterbox, Letterboxing, Scaling, fit_input
from bathbot_perception.detection.predictions import regions_from_predictions
from bathbot_perception.detection.settings import PROVIDERS, SkinDetectorSettings
from bathbot_perception.errors import ModelError, PictureError
from bathbot_perception.regions import Region

MODELS = Path(__file__).parents[1] / "models"
DEFAULT_MODEL = MODELS / "skin.onnx"
TASK = "skin-regions"
_OUTPUTS = 5 + len(SKIN_CLASSES)
_PIXELS, _VALUES = "tensor(uint8)", "tensor(float)"  # what inputs may be: pixels 0..255, or values 0..1


class ModelInput(NamedTuple):
    """What a model file says it takes: the longer side [px] and, if it takes one shape only, that (h, w).

    `pixels` says that it takes pixels 0..255, not values 0..1.
    """

    name: str
    size: int
    fixed: tuple[int, int] | None
    pixels: bool


class Detector:
    """A loaded network; make one with `load`."""

    def __init__(
        self, session: onnxruntime.InferenceSession, entry: ModelInput, settings: SkinDetectorSettings
    ) -> None:
        """Hold a session whose input was checked."""
        self._session, self._entry, self._settings = session, entry, settings
        self._letterboxing: Letterboxing | None = None
        self._scaling = None if entry.pixels else Scaling()
        self.provider: str = session.get_providers()[0]

    def bare(self, rgb: NDArray[np.uint8]) -> Callable[[], Any]:
        """The runtime's call alone on a picture of shape (H, W, 3), to time it."""
        shape = rgb.shape[0], rgb.shape[1]
        feed = {self._entry.name: self._prepared(Letterboxing(shape, self.fit(shape))(rgb)).copy()}
        return lambda: self._session.run(None, feed)

    def fit(self, shape: tuple[int, int]) -> Letterbox:
        """Where a picture of a height and width [px] goes in the network's input."""
        return fit_input(shape, self._entry.size, self._entry.fixed)

    @property
    def size(self) -> int:
        """Longer side of the network's input [px]."""
        return self._entry.size

    def detect(self, rgb: NDArray[np.uint8]) -> list[Region]:
        """Find regions of bare skin. One thread at a time.

        Args:
            rgb: Picture, shape (H, W, 3).

        Returns:
            Regions, best first, boxes [px] in the picture.

        Raises:
            PictureError: If the array is no 8-bit colour picture.
        """
        if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or rgb.size == 0:
            raise PictureError(
                f"the detector takes uint8 pictures of shape (H, W, 3), got {rgb.dtype} {rgb.shape}"
            )
        shape = rgb.shape[0], rgb.shape[1]
        if self._letterboxing is None or self._letterboxing.picture != shape:
            self._letterboxing = Letterboxing(shape, self.fit(shape))
        raw, ours = self.predict(self._letterboxing(rgb)), self._settings
        return regions_from_predictions(
            raw, self._letterboxing.fit, shape, ours.score_threshold, ours.overlap_limit, ours.most_regions
        )

    def predict(self, pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
        """The network's predictions, shape (n, 11), see `regions_from_predictions`.

        Args:
            pixels: RGB, shape (1, 3, h, w), h and w multiples of 32.
        """
        return self._session.run(None, {self._entry.name: self._prepared(pixels)})[0][0]

    def _prepared(self, pixels: NDArray[np.uint8]) -> NDArray[Any]:
        return self._scaling(pixels) if self._scaling else pixels


def load(path: Path | str | None = None, settings: SkinDetectorSettings | None = None) -> Detector:
    """Load a model and check that it is a skin detector of ours.

    Args:
        path: ONNX file; without it that of the settings, or the package's own.
        settings: Thresholds, threads and where to run.

    Raises:
        ModelError: On a missing or broken file, other classes, another shape, or a provider
            that is not there or did not take the model.
    """
    settings = settings or SkinDetectorSettings()
    file = model_file(str(path or settings.model))
    session = open_session(file, settings)
    check_classes(file, session.get_modelmeta().custom_metadata_map)
    return Detector(session, check_shapes(file, session, settings.size), settings)


def model_file(name: str) -> Path:
    """The file that is meant: the default for an empty name, one of ours for its bare name, or a path."""
    shipped = MODELS / name
    return (
        DEFAULT_MODEL
        if not name
        else shipped
        if Path(name).name == name and shipped.is_file()
        else Path(name)
    )


def open_session(file: Path, settings: SkinDetectorSettings) -> onnxruntime.InferenceSession:
    """Open an ONNX file on exactly the provider asked for."""
    if not file.is_file():
        raise ModelError(f"there is no model file {file}; set `model` to an ONNX file or leave it empty")
    provider = PROVIDERS[settings.provider]
    available = onnxruntime.get_available_providers()
    if provider not in available:
        raise ModelError(
            f"this ONNX Runtime has no {provider}, only {', '.join(available)}; set `provider` to cpu"
        )
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = settings.threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    # threads wait for each other busily, a tenth faster, but sleep after the picture: others share the cores
    options.add_session_config_entry("session.force_spinning_stop", "1")
    try:
        session = onnxruntime.InferenceSession(str(file), options, providers=[provider])
    except Exception as error:  # ONNX Runtime raises a dozen unrelated types
        reason = str(error).strip().splitlines()[0]
        raise ModelError(f"cannot load {file} as an ONNX model: {reason}; export it again") from error
    if session.get_providers()[0] != provider:
        raise ModelError(
            f"{file} runs on {session.get_providers()[0]} instead of {provider}; set `provider` to cpu"
        )
    return session


def check_classes(file: Path, metadata: dict[str, str]) -> None:
    """Refuse a model that was not trained for the six classes, in their order."""
    try:
        classes = json.loads(metadata.get("classes", "null"))
    except json.JSONDecodeError:
        classes = metadata["classes"]
    if metadata.get("task") != TASK or classes != list(SKIN_CLASSES):
        raise ModelError(
            f"{file} is no skin detector: its task is {metadata.get('task')!r}, its classes are {classes}, "
            f"expected {TASK!r} and {list(SKIN_CLASSES)}"
        )


def check_shapes(file: Path, session: onnxruntime.InferenceSession, size: int) -> ModelInput:
    """Refuse a model with other inputs or outputs than a picture and its predictions."""
    inputs, outputs = session.get_inputs(), session.get_outputs()
    shapes = f"input {[item.shape for item in inputs]}, output {[item.shape for item in outputs]}"
    wanted = f"expected input [1, 3, height, width], float32 or uint8, output [1, n, {_OUTPUTS}], float32"
    kinds = [item.type for item in (*inputs, *outputs)]
    if len(kinds) != 2 or kinds[0] not in (_PIXELS, _VALUES) or kinds[1] != _VALUES:
        raise ModelError(f"{file} has {shapes} of types {kinds}; {wanted}")
    shape = inputs[0].shape
    if len(shape) != 4 or shape[1] != 3 or len(outputs[0].shape) != 3 or outputs[0].shape[2] != _OUTPUTS:
        raise ModelError(f"{file} has {shapes}; {wanted}")
    fixed = (shape[2], shape[3]) if isinstance(shape[2], int) and isinstance(shape[3], int) else None
    if fixed and size and size != max(fixed):
        raise ModelError(f"{file} takes {fixed[1]}x{fixed[0]} px only, but `size` is {size}; set it to 0")
    if fixed:
        return ModelInput(inputs[0].name, max(fixed), fixed, kinds[0] == _PIXELS)
    said = session.get_modelmeta().custom_metadata_map.get("size", "")
    own = int(said) if said.isdigit() else 0
    if not (size or own) or (size or own) % STRIDE:
        raise ModelError(f"{file} says its input size is {said!r}, not a multiple of {STRIDE}; set `size`")
    return ModelInput(inputs[0].name, size or own, None, kinds[0] == _PIXELS)
