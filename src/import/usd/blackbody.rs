//! The colour of what glows, for the temperatures of lights.

/// Colour-matching functions of the CIE 1931 observer at a wavelength in nanometres, by the fit of Wyman, Sloan and Shirley,
/// "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", JCGT 2(2), 2013 (equation 4).
fn observer(wavelength: f64) -> [f64; 3] {
    let lobe = |middle: f64, below: f64, above: f64| {
        let width = if wavelength < middle { below } else { above };
        let t = (wavelength - middle) * width;
        (-0.5 * t * t).exp()
    };
    [
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
            - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    ]
}

/// Planck's law without its constant factor.
fn planck(wavelength: f64, kelvin: f64) -> f64 {
    /// h·c/k in nanometre kelvins.
    const SECOND: f64 = 1.438_776_877e7;
    (wavelength / 560.0).powi(-5) / (SECOND / (wavelength * kelvin)).exp_m1()
}

/// Linear Rec.709 of luminance 1; what lies outside of it is brought to its border. USD reads temperatures from 1000 K to 10000 K.
pub(super) fn rec709(kelvin: f64) -> [f64; 3] {
    let kelvin = if kelvin.is_finite() {
        kelvin.clamp(1000.0, 10_000.0)
    } else {
        6500.0
    };
    let mut xyz = [0.0; 3];
    for step in 0..=94 {
        let wavelength = 360.0 + 5.0 * f64::from(step);
        let power = planck(wavelength, kelvin);
        for (sum, weight) in xyz.iter_mut().zip(observer(wavelength)) {
            *sum += power * weight;
        }
    }
    let [x, y, z] = xyz.map(|v| v / xyz[1]);
    // IEC 61966-2-1.
    let rgb = [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ];
    let [r, g, b] = rgb.map(|v| v.max(0.0));
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    [r, g, b].map(|v| v / luminance)
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/blackbody.rs"]
mod tests;
