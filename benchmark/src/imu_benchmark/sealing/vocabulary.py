"""Names of all hidden effects: those of the controlled vocabulary, and those outside of it."""

from imu_benchmark.sealing import additive, inertial, output, unnamed
from imu_benchmark.sealing.hidden_effect import HiddenEffect

NAMED: dict[str, type[HiddenEffect]] = {
    kind.name: kind
    for kind in (
        additive.HiddenWhiteNoise,
        additive.HiddenBiasInstability,
        additive.HiddenRandomWalk,
        additive.HiddenQuantization,
        additive.HiddenRateRamp,
        additive.HiddenGaussMarkov,
        additive.HiddenSinusoid,
        additive.HiddenChirp,
        additive.HiddenRandomTelegraph,
        additive.HiddenOutliers,
        additive.HiddenBiasStep,
        additive.HiddenWarmUp,
        additive.HiddenTemperature,
        output.HiddenVarianceChange,
        additive.HiddenCommonMode,
        output.HiddenResolution,
        output.HiddenOutputFilter,
        output.HiddenStuckSamples,
        output.HiddenSampleLoss,
        output.HiddenTimestampJitter,
        additive.HiddenTurnOnBias,
        output.HiddenClockScale,
        output.HiddenSaturation,
        output.HiddenDeadZone,
        inertial.HiddenScaleFactor,
        inertial.HiddenMisalignment,
        inertial.HiddenGSensitivity,
        inertial.HiddenVibrationRectification,
        inertial.HiddenLeverArm,
        inertial.HiddenTimeOffset,
    )
}
UNNAMED: dict[str, type[HiddenEffect]] = {
    kind.name: kind
    for kind in (
        unnamed.HiddenSweep,
        unnamed.HiddenHysteresis,
        unnamed.HiddenVanDerPol,
        unnamed.HiddenFractionalNoise,
        unnamed.HiddenBursts,
        unnamed.HiddenSawtooth,
    )
}
ALL = NAMED | UNNAMED
