//! Blender's Thin Wall: a pane with reflections between its sides, and a sheet that light is scattered through
//! (OpenPBR 1.1, the thin-walled case).

use super::bsdf::Bsdf;
use super::closure::{BsdfFeatures, Facets, Lobe, Reflection, Sheet, Translucent};
use super::fresnel::{self, Fresnel};
use super::ggx::Alpha;
use super::principled::Principled;
use super::tables::{LutCoordinate, Reflection as Albedos};
use super::thin_film::Film;
use crate::math::sqr;
use crate::scene::graph::ShaderRules;
use glam::Vec3;

/// By how much the slopes of a pane spread what goes through it: both sides of it (Kulla and Conty, *Revisiting Physically Based
/// Shading at Imageworks*, 2017, p. 40; 3.4 is twice 1.7, as Cycles has it).
fn spread(ior: f32, rules: ShaderRules) -> f32 {
    let of_alpha = (3.4 * (ior - 1.0) * sqr(ior - 0.5) / (ior * ior * ior)).max(0.0);
    match rules {
        // The slides' root is for the perceptual roughness, but Cycles takes it for α.
        ShaderRules::Before53 => of_alpha.sqrt(),
        ShaderRules::Since53 => of_alpha,
    }
}

/// What a pane reflects and lets through, with all that goes to and fro in it.
fn pane(cos: f32, ior: f32, film: Film, specular: Vec3, tint: Vec3) -> [Vec3; 2] {
    let true_f0 = fresnel::f0_from_ior(ior);
    let f0 = (specular * true_f0).min(Vec3::ONE);
    let side = fresnel::dielectric(cos, ior);
    let blend = fresnel::grazing_blend(side.reflectance, true_f0);
    let plain = f0 + (Vec3::ONE - f0) * blend;
    let (r, inner_r) = if film.is_there() {
        let below = film.seen_from(true, ior);
        (
            film.over_dielectric(cos, ior, f0),
            below.over_dielectric(side.cos_t, 1.0 / ior, f0),
        )
    } else {
        (plain, plain)
    };
    // Beer's law: the tint is that of the way straight through.
    let inner = if side.cos_t > 0.0 {
        tint.powf(1.0 / side.cos_t)
    } else {
        Vec3::ZERO
    };
    let back = inner_r * inner;
    let sum = (Vec3::ONE - back * back).max(Vec3::splat(f32::MIN_POSITIVE));
    let through = inner * (Vec3::ONE - r) * (Vec3::ONE - inner_r) / sum;
    [r + through * back, through]
}

/// What a sheet under a film reflects and lets through: glTF's has one side that reflects.
fn filmed_sheet(cos: f32, ior: f32, film: Film, specular: Vec3, tint: Vec3) -> [Vec3; 2] {
    let f0 = (specular * fresnel::f0_from_ior(ior)).min(Vec3::ONE);
    let reflected = film.over_dielectric(cos, ior, f0).min(Vec3::ONE);
    [reflected, tint * (Vec3::ONE - reflected)]
}

impl<K: BsdfFeatures> Bsdf<K> {
    /// Adds a pane, or glTF's sheet under a film: reflection, and the same mirrored to the other side.
    #[cold]
    #[inline(never)]
    pub(super) fn add_pane(&mut self, share: f32, p: &Principled, ior: f32, normal: Vec3) {
        let alpha = sqr(p.roughness);
        let base = p.base_color.min(Vec3::ONE);
        let (normals, wo) = (*self.normals(), self.wo());
        let least = self.roughened(Alpha::isotropic(0.0)).xy.x;
        let facets = |alpha: f32| {
            let roughened = Alpha::isotropic(alpha.max(least));
            let alpha = Alpha::isotropic(alpha);
            let facets = Facets::new(&normals, normal, None, wo, roughened);
            let place = LutCoordinate::new(facets.cos(), alpha.mean_roughness());
            (facets, (!alpha.is_smooth()).then(|| Albedos::at(place)))
        };
        let (before, albedos) = facets(alpha);
        let cos = before.cos();
        if cos <= 0.0 {
            return;
        }
        let shares = if p.pane { pane } else { filmed_sheet };
        let [reflected, through] = shares(cos, ior, p.film, p.specular_color, base);
        let [reflects, transmits] = self.keeps_caustics();
        if reflects {
            let color = p.specular_color.min(Vec3::ONE);
            let gain = albedos.map_or(Vec3::ONE, |a| a.compensation(color));
            let single = albedos.map_or(1.0, |a| a.directional);
            let weight = reflected * gain * share;
            let lobe = Reflection {
                weight,
                facets: before,
                fresnel: Fresnel::Constant,
            };
            self.add(Lobe::Reflection(lobe), weight * single);
        }
        if transmits {
            // glTF spreads what goes through as what is reflected.
            let spread = if p.pane { spread(ior, p.rules) } else { 1.0 };
            let (behind, albedos) = facets((alpha * spread).min(1.0));
            let single = albedos.map_or(1.0, |a| a.directional);
            let lobe = Sheet {
                weight: Vec3::splat(share / single),
                reflected: Vec3::ZERO,
                f0: Vec3::ZERO,
                tint: through,
                eta: 1.5,
                // With 1 no angle reflects more than at normal incidence, which is nothing.
                true_f0: 1.0,
                facets: behind.unbounded(),
            };
            self.add(Lobe::Sheet(lobe), Vec3::splat(share));
        }
    }

    /// Adds what a dense sheet scatters to both sides.
    #[cold]
    #[inline(never)]
    pub(super) fn add_thin_subsurface(&mut self, weight: f32, p: &Principled, normal: Vec3) {
        let color = p.subsurface_color.min(Vec3::ONE) * weight;
        let behind = (0.5 * (1.0 + p.subsurface_anisotropy)).clamp(0.0, 1.0);
        self.add_lambert(color * (1.0 - behind), normal);
        let color = color * behind;
        if color != Vec3::ZERO {
            self.add(Lobe::Translucent(Translucent { color, normal }), color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_sheets_under_films_lose_nothing() {
        let film = Film {
            thickness: 400.0,
            ior: 1.8,
            space: Default::default(),
        };
        for cos in [1.0, 0.5, 0.1] {
            let [reflected, through] = filmed_sheet(cos, 1.5, film, Vec3::ONE, Vec3::ONE);
            assert!((reflected + through - Vec3::ONE).abs().max_element() < 1e-6);
            assert!(cos < 1.0 || reflected.max_element() > 0.05);
        }
    }

    #[test]
    fn clear_panes_lose_nothing_and_tinted_ones_take_their_tint_once() {
        for cos in [1.0, 0.5, 0.1] {
            let [reflected, through] = pane(cos, 1.5, Film::NONE, Vec3::ONE, Vec3::ONE);
            let sum = reflected + through;
            assert!((sum - Vec3::ONE).abs().max_element() < 1e-6);
            // Two sides of 4 % reflect 7.7 % between them.
            assert!(cos < 1.0 || (reflected.x - 2.0 * 0.04 / 1.04).abs() < 1e-5);
        }
        let [_, through] = pane(1.0, 1.0, Film::NONE, Vec3::ONE, Vec3::new(0.25, 0.5, 1.0));
        assert_eq!(through, Vec3::new(0.25, 0.5, 1.0));
    }
}
