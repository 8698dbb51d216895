//! IES files of lights, as UsdLux reads them.

use crate::import::ies;
use crate::nodes::ies::IesProfile;

/// What a light is multiplied by in each direction. Angles about the axis go from +X to +Y, as in USD's own renderer, hdEmbree.
/// `scale` rescales the angles from the axis: from 0° where it is above 0, from 180° where it is below.
pub(super) fn profile(bytes: &[u8], normalize: bool, scale: f64) -> Result<IesProfile, String> {
    let luminaire = ies::parse(bytes)?;
    if luminaire.is_of_another_type {
        return Err("its angles are not about the vertical axis (type C)".into());
    }
    let share = if normalize { luminaire.mean } else { 1.0 };
    // Not a number, neither.
    if share.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
        return Err("it gives no light".into());
    }
    let rescaled = |angle: f64| {
        if scale > 0.0 {
            angle * scale
        } else if scale < 0.0 {
            std::f64::consts::PI - (std::f64::consts::PI - angle) * -scale
        } else {
            angle
        }
    };
    let mut profile = luminaire.candela;
    for angle in &mut profile.down {
        *angle = rescaled(f64::from(*angle)) as f32;
    }
    for strength in &mut profile.strengths {
        *strength = (f64::from(*strength) / share) as f32;
    }
    if profile.is_sane() {
        Ok(profile)
    } else {
        Err("its numbers do not fit together".into())
    }
}

#[cfg(test)]
#[path = "../../../tests/unit/import/usd/ies.rs"]
mod tests;
