//! The measures as a list, for tables.

use super::Difference;

/// One measure of a difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// Its name.
    pub name: &'static str,
    /// How much it is; none if it says nothing of these pictures.
    pub value: Option<f64>,
    /// What it is.
    pub explanation: &'static str,
}

impl Difference {
    /// All measures, in the order in which they are shown.
    pub fn measures(&self) -> Vec<Measure> {
        let measure = |name, value, explanation| Measure {
            name,
            value,
            explanation,
        };
        let rows = [
            (
                "error (%)",
                Some(100.0 * self.rel_mse.sqrt()),
                "√relMSE: the root of the mean over pixels and channels of (a − b)² / (b² + 0.01), with b the reference",
            ),
            (
                "relMSE",
                Some(self.rel_mse),
                "its square: falls as 1 / samples",
            ),
            (
                "RMSE",
                Some(self.rmse),
                "root of the mean of (a − b)²: rules where the picture is bright",
            ),
            (
                "MAPE",
                Some(self.mape),
                "mean of |a − b| / (|b| + 0.01): heeds single bright pixels less",
            ),
            (
                "SMAPE",
                Some(self.smape),
                "mean of 2 |a − b| / (|a| + |b| + 0.02), 0 to 2",
            ),
            (
                "largest |a − b|",
                Some(self.largest),
                "of one channel of one pixel",
            ),
            (
                "mean luminance of a",
                Some(self.mean_luminance_a),
                "Rec.709 weights",
            ),
            (
                "mean luminance of b",
                Some(self.mean_luminance_b),
                "Rec.709 weights",
            ),
            (
                "ratio of luminances",
                self.luminance_ratio,
                "a over b: 1 if nothing is too bright or too dark as a whole",
            ),
            (
                "SSIM",
                self.ssim,
                "mean structural similarity of what one sees: 1 is the same picture",
            ),
            (
                "FLIP",
                Some(self.flip),
                "mean of LDR-FLIP, the difference that one sees when the pictures alternate: 0 to 1",
            ),
            (
                "HDR-FLIP",
                self.hdr_flip,
                "the same over all exposures that show something",
            ),
        ];
        rows.map(|(name, value, explanation)| measure(name, value, explanation))
            .to_vec()
    }
}
