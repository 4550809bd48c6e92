"""The state of the live correction: which camera is connected, what it sends, and how good it is."""

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit, OtherCameraError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.registration import Region
from bathbot_depthcorr.live.frame_quality import LEAST_FILL, Centre, FrameQuality, judge_frame, quality_values
from bathbot_depthcorr.live.live_region import LiveRegion
from bathbot_depthcorr.live.settings import Settings
from bathbot_depthcorr.models.correction_model import Correction, Identity
from bathbot_depthcorr.ros.camera_health import CameraHealth
from bathbot_depthcorr.ros.verdict import Level, Verdict

Depth = NDArray[np.float32]


class LiveCorrection:
    """Corrects frames of one camera and judges them; knows nothing of messages or time.

    Attributes:
        region: The region of the colour image that depth is carried to, if one is wanted.
    """

    def __init__(self, settings: Settings, correction: Correction | None) -> None:
        """Start without a camera.

        Args:
            settings: Of the node.
            correction: From a file; None lets depth pass uncorrected.
        """
        self._settings, self._stored = settings, correction
        self._active: Correction | None = None
        self._refusal = "waiting for the depth camera's camera_info"
        self._health = CameraHealth(settings.serial)
        self._camera: Pinhole | None = None
        self._samples: tuple[Depth | None, Depth | None] = (None, None)
        self.quality: FrameQuality | None = None
        self.region = LiveRegion(Region(*settings.registered_roi), settings.max_depth)
        if correction is not None:
            self.region.meet_transform(correction.T_colour_depth)

    @property
    def active(self) -> Correction | None:
        """The correction in use; None while no camera was accepted."""
        return self._active

    def meet_camera(self, camera: Pinhole) -> bool:
        """Take note of the camera's intrinsics; tell whether the correction in use changed."""
        self.region.meet_depth_camera(camera)
        if camera == self._camera:
            return False
        self._camera, self._centre = camera, Centre(camera)
        self._samples = (None, None)
        return self._decide()

    def meet_health(self, health: CameraHealth) -> bool:
        """Take note of serial number and temperature; tell whether the correction in use changed."""
        changed = health.serial != self._health.serial and not self._settings.serial
        self._health = replace_serial(health, self._settings.serial)
        return self._decide() if changed and self._camera is not None else False

    @property
    def health(self) -> CameraHealth:
        """Serial number and temperature, as far as known."""
        return self._health

    def process(self, depth: Depth, out: Depth | None = None) -> Depth | None:
        """Correct a frame [m], shape (H, W); None while the camera is refused.

        Writes to `out`, float32 of the same shape; to a new array by default.

        Raises:
            DepthShapeError: If the frame has another size than camera_info says.
        """
        if self._active is None:
            return None
        corrected = self._active.apply(depth, out)
        np.copyto(corrected, np.nan, where=corrected > self._settings.max_depth)
        self._samples = (self._samples[1], self._centre.sample(corrected))
        return corrected

    def judge(self, corrected: Depth) -> None:
        """Look closely at the frame that `process` gave last; takes as long as correcting a few."""
        if self._active is not None:
            self.quality = judge_frame(
                self._active, corrected, self._centre, self._samples[0], self._settings.wall_distance
            )

    def lose_sight(self) -> None:
        """Take note that no frames come any more."""
        self.quality, self._samples = None, (None, None)

    def verdict(self) -> Verdict:
        """How well it goes, in one line."""
        verdict = self._of_correction()
        if verdict.level is not Level.ERROR and self.region.trouble:
            return Verdict(Level.ERROR, f"registered_roi: {self.region.trouble}")
        return verdict

    def values(self, fps: float, dropped: int) -> dict[str, str]:
        """What a diagnostic tells beside the verdict: the camera, its frames and their quality."""
        health = self._health
        return {
            "model": self._stored.model if self._stored else "none",
            "serial": health.serial or "unknown",
            "fps": f"{fps:.1f}",
            "dropped": str(dropped),
            "temperature": f"{health.temperature:.1f}",
            **quality_values(self.quality, self._settings.wall_distance),
        }

    def _of_correction(self) -> Verdict:
        if self._active is None:
            return Verdict(Level.WARN if self._camera is None else Level.ERROR, self._refusal)
        if self.quality is None:
            return Verdict(Level.WARN, "waiting for depth images; is the camera streaming depth?")
        if self.quality.fill < LEAST_FILL:
            return Verdict(
                Level.ERROR,
                f"no depth: {self.quality.fill:.1%} of the pixels have any; is the lens covered or fogged?",
            )
        if self._stored is None:
            return Verdict(
                Level.WARN,
                "depth passes uncorrected (no calibration); make one with: bathbot calibrate depth",
            )
        drift = self._health.temperature - self._active.temperature
        if abs(drift) > self._settings.max_temperature_change:
            return Verdict(
                Level.WARN,
                f"camera is {drift:+.1f} deg C from its calibration; let it warm up or calibrate again",
            )
        return Verdict(Level.OK, "correcting")

    def _decide(self) -> bool:
        before, self._active = self._active, None
        try:
            if self._stored is not None:
                self._stored.unit.refuse_other(self._camera, self._health.serial)
                self._active = self._stored
            else:
                self._active = Identity(CameraUnit(self._camera, serial=self._health.serial))
        except OtherCameraError as error:
            self._refusal = str(error)
        return self._active is not before


def replace_serial(health: CameraHealth, serial: str) -> CameraHealth:
    """The same health under a serial number the user gave; empty keeps the camera's own."""
    return health._replace(serial=serial) if serial else health
