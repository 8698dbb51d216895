//! The colour of what glows, for the temperatures of lights: as UsdLux defines it, by a spline through a table of its own.

/// Linear Rec.709 of what glows at 1000 K, 1500 K, … 10000 K, each by its largest component: what
/// `UsdLux.BlackbodyTemperatureAsRgb` of usd-core 26.11 gives there.
const GLOW: [[f64; 3]; 19] = [
    [1.0, 0.027_490, 0.0],
    [1.0, 0.149_664, 0.0],
    [1.0, 0.256_644, 0.008_095],
    [1.0, 0.372_033, 0.067_450],
    [1.0, 0.476_725, 0.153_601],
    [1.0, 0.570_376, 0.259_196],
    [1.0, 0.653_480, 0.377_155],
    [1.0, 0.726_878, 0.501_606],
    [1.0, 0.791_543, 0.628_050],
    [1.0, 0.848_462, 0.753_228],
    [1.0, 0.898_581, 0.874_905],
    [1.0, 0.942_771, 0.991_642],
    [0.906_947, 0.890_456, 1.0],
    [0.828_247, 0.841_838, 1.0],
    [0.765_791, 0.801_896, 1.0],
    [0.715_255, 0.768_579, 1.0],
    [0.673_683, 0.740_423, 1.0],
    [0.638_992, 0.716_359, 1.0],
    [0.609_681, 0.695_588, 1.0],
];
/// Kelvin of the first, and between them.
const FIRST: f64 = 1000.0;
const STEP: f64 = 500.0;
/// Weights of Rec.709 (ITU-R BT.709).
const LUMA: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Linear Rec.709 of luminance 1. Below 1000 K and above 10000 K it stays as there.
pub(super) fn rec709(kelvin: f64) -> [f64; 3] {
    let last = GLOW.len() - 1;
    let kelvin = if kelvin.is_nan() { 6500.0 } else { kelvin };
    let at = ((kelvin - FIRST) / STEP).clamp(0.0, last as f64);
    let before = (at as usize).min(last - 1);
    let t = at - before as f64;
    // The curve of Catmull and Rom; the outermost values stand twice.
    let [a, b, c, d] = [
        before.saturating_sub(1),
        before,
        before + 1,
        (before + 2).min(last),
    ];
    let rgb = [0, 1, 2].map(|i| {
        let [a, b, c, d] = [a, b, c, d].map(|row| GLOW[row][i]);
        let cubic = 3.0 * (b - c) + d - a;
        let square = 2.0 * a - 5.0 * b + 4.0 * c - d;
        b + 0.5 * t * (c - a + t * (square + t * cubic))
    });
    let luminance: f64 = rgb.iter().zip(LUMA).map(|(v, weight)| v * weight).sum();
    rgb.map(|v| (v / luminance).max(0.0))
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/blackbody.rs"]
mod tests;
