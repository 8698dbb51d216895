//! Interference in a thin film on a surface (Belcour and Barla, *A Practical Extension to Microfacet Theory for the Modeling of
//! Varying Iridescence*, SIGGRAPH 2017): Airy's sum over the ways to and fro in it, each integrated over the wavelengths by the
//! Fourier transform of the colour-matching functions.

use super::closure::microfacet::Reflectance;
use super::fresnel::{self, Fresnel};
use crate::math::primaries::WorkingSpace;
use crate::math::{mix, sqr};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use std::sync::OnceLock;

/// A film of one thickness.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    /// Nanometres.
    pub thickness: f32,
    /// Index of refraction.
    pub ior: f32,
    /// The space of the colours.
    pub space: WorkingSpace,
}

/// Thinner films are not there (nanometres), as in Cycles.
const LEAST: f32 = 0.1;

/// Entries of the transform.
const ENTRIES: usize = 512;
/// 2π times the greatest difference of paths (nanometres).
const RANGE: f32 = 60_000.0;

/// By entry, the cosine and the sine transform of each colour.
type Transform = [[Vec3; 2]; ENTRIES];

/// The transform of the matching functions of a space's primaries.
fn transform(space: WorkingSpace) -> &'static Transform {
    static TABLES: [OnceLock<Box<Transform>>; 3] = [const { OnceLock::new() }; 3];
    let place = WorkingSpace::ALL.iter().position(|s| *s == space);
    TABLES[place.unwrap_or(0)].get_or_init(|| {
        let entry = |i: usize| {
            let phase = f64::from(RANGE) * i as f64 / (ENTRIES - 1) as f64;
            let mut sums = [glam::DVec3::ZERO; 2];
            for (k, matching) in CIE_1931.iter().enumerate() {
                let (sin, cos) = (phase / (FIRST + STEP * k as f64)).sin_cos();
                let matching = glam::DVec3::from(*matching);
                sums[0] += matching * cos;
                sums[1] += matching * sin;
            }
            sums.map(|xyz| space.from_xyz() * xyz)
        };
        let whole = entry(0)[0];
        Box::new(std::array::from_fn(|i| {
            entry(i).map(|sum| (sum / whole).as_vec3())
        }))
    })
}

/// What an interface reflects, of light polarised across the plane of incidence and along it, and the phase by which each is
/// shifted, as a complex number.
#[derive(Clone, Copy)]
struct Interface {
    reflectance: Vec2,
    phase: [Vec2; 2],
}

/// Between dielectrics; with the cosine of the refracted ray. `None` where all is reflected.
fn dielectric(cos: f32, eta: f32) -> Option<(Interface, f32)> {
    let square = 1.0 - (1.0 - sqr(cos)) / sqr(eta);
    if square <= 0.0 {
        return None;
    }
    let inner = square.sqrt();
    let across = (cos - eta * inner) / (cos + eta * inner);
    let along = (eta * cos - inner) / (eta * cos + inner);
    let sign = |r: f32| Vec2::new(if r < 0.0 { -1.0 } else { 1.0 }, 0.0);
    let of = Interface {
        reflectance: Vec2::new(sqr(across), sqr(along)),
        phase: [sign(across), sign(along)],
    };
    Some((of, inner))
}

/// From a film into a conductor (Born and Wolf, *Principles of Optics*, 14.4.1).
fn conductor(cos: f32, ior: f32, (n, k): (f32, f32)) -> Interface {
    let (real, cross) = (n * n - k * k, 2.0 * n * k);
    let difference = real - sqr(ior) * (1.0 - sqr(cos));
    let length = Vec2::new(difference, cross).length();
    let root = |square: f32| square.max(0.0).sqrt();
    let (u, v) = (
        root(0.5 * (length + difference)),
        root(0.5 * (length - difference)),
    );
    let share = |a: f32, b: f32| if b > 0.0 { a / b } else { 0.0 };
    let c = ior * cos;
    let across = share(sqr(c - u) + sqr(v), sqr(c + u) + sqr(v));
    let (a, b) = (real * cos, cross * cos);
    let along = share(
        sqr(a - ior * u) + sqr(b - ior * v),
        sqr(a + ior * u) + sqr(b + ior * v),
    );
    let unit = |re: f32, im: f32| Vec2::new(re, im).normalize_or(Vec2::X);
    let both = u * u + v * v;
    Interface {
        reflectance: Vec2::new(across, along),
        phase: [
            unit(sqr(c) - both, -2.0 * c * v),
            unit(
                sqr((n * n + k * k) * cos) - sqr(ior) * both,
                2.0 * c * (cross * u - real * v),
            ),
        ],
    }
}

/// Airy's sum for one channel and one polarisation, to its third term.
fn airy(
    table: &Transform,
    channel: usize,
    path: f32,
    [above, below]: [f32; 2],
    phase: Vec2,
) -> f32 {
    let (through, both) = (1.0 - above, above * below);
    let steady = sqr(through) * below / (1.0 - both).max(f32::MIN_POSITIVE);
    let mut sum = steady + above;
    let mut strength = steady - through;
    let mut turned = phase;
    for m in 1..=3u8 {
        strength *= both.sqrt();
        let x = (TAU * f32::from(m) * path / RANGE).clamp(0.0, 1.0) * (ENTRIES - 1) as f32;
        let i = (x as usize).min(ENTRIES - 2);
        let at = |part: usize| {
            mix(
                table[i][part][channel],
                table[i + 1][part][channel],
                x - i as f32,
            )
        };
        sum += 2.0 * strength * (turned.x * at(0) - turned.y * at(1));
        turned = turned.rotate(phase);
    }
    sum
}

impl Film {
    /// No film.
    pub const NONE: Self = Self {
        thickness: 0.0,
        ior: 1.33,
        space: WorkingSpace::Rec709,
    };

    /// The film as light meets it that comes from inside what it lies on: all indices relative to that one.
    #[must_use]
    pub fn seen_from(self, inside: bool, ior: f32) -> Self {
        Self {
            ior: if inside { self.ior / ior } else { self.ior },
            ..self
        }
    }

    /// The film on what is in something of an index: its own relative to that, and as thick for light as it is.
    #[must_use]
    pub fn beside(self, other_side: f32) -> Self {
        Self {
            ior: self.ior / other_side,
            thickness: self.thickness * other_side,
            ..self
        }
    }

    /// Whether it is thick enough to be seen.
    pub fn is_there(&self) -> bool {
        self.thickness > LEAST
    }

    /// Its index; the thinnest go over into none.
    fn index(&self) -> f32 {
        let t = self.thickness.clamp(0.0, 1.0);
        mix(1.0, self.ior, t * t * (3.0 - 2.0 * t))
    }

    /// One channel of what is reflected, by what lies below for the cosine in the film; `None` where that reflects all.
    fn channel(
        &self,
        channel: usize,
        cos: f32,
        below: impl Fn(f32, f32) -> Option<Interface>,
    ) -> f32 {
        let ior = self.index();
        let Some((above, inner)) = dielectric(cos, ior) else {
            return 1.0;
        };
        let Some(below) = below(inner, ior) else {
            return 1.0;
        };
        let path = 2.0 * ior * self.thickness * inner;
        let table = transform(self.space);
        let part = |i: usize| {
            // From inside the film the upper interface shifts the phase the other way.
            let phase = below.phase[i] * -above.phase[i].x;
            airy(
                table,
                channel,
                path,
                [above.reflectance[i], below.reflectance[i]],
                phase,
            )
        };
        (0.5 * (part(0) + part(1))).clamp(0.0, 1.0)
    }

    /// Reflectance over a dielectric of a relative index, whose reflectance at normal incidence is `f0` instead of its own.
    pub fn over_dielectric(&self, cos: f32, eta: f32, f0: Vec3) -> Vec3 {
        let below = |cos: f32, ior: f32| dielectric(cos, eta / ior).map(|(of, _)| of);
        let all = Vec3::from_array([0, 1, 2].map(|c| self.channel(c, cos, below)));
        let own = fresnel::f0_from_ior(eta);
        if own <= 1e-5 || all == Vec3::ONE {
            return all;
        }
        // The less is reflected the more of the factor counts, as in Cycles.
        let share = ((Vec3::ONE - all) / (1.0 - own)).clamp(Vec3::ZERO, Vec3::ONE);
        all * (Vec3::ONE + (f0 / own - Vec3::ONE) * share)
    }

    /// Reflectance over a conductor.
    pub fn over_conductor(&self, cos: f32, n: Vec3, k: Vec3) -> Vec3 {
        let channel = |c: usize| {
            let below = |cos: f32, ior: f32| Some(conductor(cos, ior, (n[c], k[c])));
            self.channel(c, cos, below)
        };
        Vec3::from_array([0, 1, 2].map(channel))
    }

    /// Reflectance over a metal of these reflectances at normal incidence and at a cosine of 1/7 (Gulbrandsen, *Artist Friendly
    /// Metallic Fresnel*, JCGT 3(4), 2014, for the phases).
    pub fn over_metal(&self, cos: f32, f0: Vec3, edge: Vec3) -> Vec3 {
        let channel = |c: usize| {
            let (r, g) = (f0[c].min(0.999), edge[c]);
            let root = r.sqrt();
            let n = mix((1.0 + root) / (1.0 - root), (1.0 - r) / (1.0 + r), g);
            let k = ((r * sqr(n + 1.0) - sqr(n - 1.0)) / (1.0 - r))
                .max(0.0)
                .sqrt();
            let below = |cos: f32, ior: f32| {
                let of = conductor(cos, ior, (n, k));
                let (n, k) = (n / ior, sqr(k / ior));
                let f0 = (sqr(n - 1.0) + k) / (sqr(n + 1.0) + k);
                let reflectance = fresnel::bent(cos, f0, g);
                Some(Interface {
                    reflectance: Vec2::splat(reflectance),
                    ..of
                })
            };
            self.channel(c, cos, below)
        };
        Vec3::from_array([0, 1, 2].map(channel))
    }
}

/// The reflectance of facets under a film.
#[derive(Clone, Copy, Debug)]
pub enum Filmed {
    /// A dielectric by its relative index, with a reflectance at normal incidence.
    Dielectric(Film, f32, Vec3),
    /// A conductor by the parts of its index.
    Conductor(Film, Vec3, Vec3),
    /// A metal by its reflectances at normal incidence and at cosθ = 1/7.
    Metal(Film, Vec3, Vec3),
}

impl Filmed {
    /// What facets of a metal reflect under a film.
    pub fn metal(film: Film, metal: &Fresnel) -> Self {
        match *metal {
            Fresnel::Conductor { n, k } => Self::Conductor(film, n, k),
            _ => Self::Metal(film, metal.reflectance(1.0), metal.reflectance(1.0 / 7.0)),
        }
    }
}

impl Reflectance for Filmed {
    #[cold]
    #[inline(never)]
    fn reflectance(&self, cos: f32) -> Vec3 {
        match *self {
            Self::Dielectric(film, eta, f0) => film.over_dielectric(cos, eta, f0),
            Self::Conductor(film, n, k) => film.over_conductor(cos, n, k),
            Self::Metal(film, f0, edge) => film.over_metal(cos, f0, edge),
        }
    }
}

/// Wavelength of the first entry, and between entries (nanometres).
pub(super) const FIRST: f64 = 380.0;
pub(super) const STEP: f64 = 5.0;

/// The colour-matching functions of the CIE's standard observer of 1931 (CIE 018:2019, table 6; x, y and z).
#[rustfmt::skip]
pub(super) static CIE_1931: [[f64; 3]; 81] = [
    [0.001368, 0.000039, 0.00645],
    [0.002236, 0.000064, 0.01055],
    [0.004243, 0.00012, 0.02005],
    [0.00765, 0.000217, 0.03621],
    [0.01431, 0.000396, 0.06785],
    [0.02319, 0.00064, 0.1102],
    [0.04351, 0.00121, 0.2074],
    [0.07763, 0.00218, 0.3713],
    [0.13438, 0.004, 0.6456],
    [0.21477, 0.0073, 1.03905],
    [0.2839, 0.0116, 1.3856],
    [0.3285, 0.01684, 1.62296],
    [0.34828, 0.023, 1.74706],
    [0.34806, 0.0298, 1.7826],
    [0.3362, 0.038, 1.77211],
    [0.3187, 0.048, 1.7441],
    [0.2908, 0.06, 1.6692],
    [0.2511, 0.0739, 1.5281],
    [0.19536, 0.09098, 1.28764],
    [0.1421, 0.1126, 1.0419],
    [0.09564, 0.13902, 0.81295],
    [0.05795, 0.1693, 0.6162],
    [0.03201, 0.20802, 0.46518],
    [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272],
    [0.0024, 0.4073, 0.2123],
    [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117],
    [0.06327, 0.71, 0.07825],
    [0.1096, 0.7932, 0.05725],
    [0.1655, 0.862, 0.04216],
    [0.22575, 0.91485, 0.02984],
    [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134],
    [0.43345, 0.99495, 0.00875],
    [0.51205, 1.0, 0.00575],
    [0.5945, 0.995, 0.0039],
    [0.6784, 0.9786, 0.00275],
    [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018],
    [0.9163, 0.87, 0.00165],
    [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011],
    [1.0567, 0.6949, 0.001],
    [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006],
    [1.0026, 0.503, 0.00034],
    [0.9384, 0.4412, 0.00024],
    [0.85445, 0.381, 0.00019],
    [0.7514, 0.321, 0.0001],
    [0.6424, 0.265, 0.00005],
    [0.5419, 0.217, 0.00003],
    [0.4479, 0.175, 0.00002],
    [0.3608, 0.1382, 0.00001],
    [0.2835, 0.107, 0.0],
    [0.2187, 0.0816, 0.0],
    [0.1649, 0.061, 0.0],
    [0.1212, 0.04458, 0.0],
    [0.0874, 0.032, 0.0],
    [0.0636, 0.0232, 0.0],
    [0.04677, 0.017, 0.0],
    [0.0329, 0.01192, 0.0],
    [0.0227, 0.00821, 0.0],
    [0.01584, 0.005723, 0.0],
    [0.0113592, 0.004102, 0.0],
    [0.00811092, 0.002929, 0.0],
    [0.00579035, 0.002091, 0.0],
    [0.00410946, 0.001484, 0.0],
    [0.00289933, 0.001047, 0.0],
    [0.00204919, 0.00074, 0.0],
    [0.00143997, 0.00052, 0.0],
    [0.000999949, 0.0003611, 0.0],
    [0.000690079, 0.0002492, 0.0],
    [0.000476021, 0.0001719, 0.0],
    [0.000332301, 0.00012, 0.0],
    [0.000234826, 0.0000848, 0.0],
    [0.000166151, 0.00006, 0.0],
    [0.000117413, 0.0000424, 0.0],
    [0.00008308, 0.00003, 0.0],
    [0.00005871, 0.0000212, 0.0],
    [0.00004151, 0.00001499, 0.0],
];

#[cfg(test)]
mod tests {
    use super::*;

    const FILM: Film = Film {
        thickness: 400.0,
        ior: 1.33,
        space: WorkingSpace::Rec709,
    };

    #[test]
    fn a_film_of_the_same_index_is_not_seen() {
        for cos in [1.0, 0.5, 0.1] {
            let plain = fresnel::dielectric(cos, 1.5).reflectance;
            for ior in [1.0, 1.5] {
                let film = Film { ior, ..FILM };
                let seen = film.over_dielectric(cos, 1.5, Vec3::splat(0.04));
                assert!(
                    (seen - Vec3::splat(plain)).abs().max_element() < 1e-5,
                    "{seen} {plain}"
                );
            }
            let (n, k) = (Vec3::new(0.2, 0.9, 2.7), Vec3::new(3.9, 2.5, 3.8));
            let film = Film { ior: 1.0, ..FILM };
            let error = film.over_conductor(cos, n, k) - fresnel::conductor(cos, n, k);
            assert!(error.abs().max_element() < 1e-4, "{error}");
        }
    }

    /// Beside Airy's formula in full, integrated over the wavelengths.
    #[test]
    fn colours_are_those_of_all_wavelengths() {
        for (thickness, cos) in [(300.0, 1.0), (500.0, 0.6), (900.0, 0.3)] {
            let film = Film { thickness, ..FILM };
            let (above, inner) = dielectric(cos, film.ior).unwrap();
            let (below, _) = dielectric(inner, 1.5 / film.ior).unwrap();
            let path = f64::from(2.0 * film.ior * thickness * inner);
            let (mut sum, mut whole) = (glam::DVec3::ZERO, glam::DVec3::ZERO);
            for (k, matching) in CIE_1931.iter().enumerate() {
                let phase = std::f64::consts::TAU * path / (FIRST + STEP * k as f64);
                let part = |i: usize| {
                    let r = f64::from(above.reflectance[i] * below.reflectance[i]).sqrt();
                    let sign = f64::from(-above.phase[i].x * below.phase[i].x);
                    let (a, b) = (
                        f64::from(above.reflectance[i]),
                        f64::from(below.reflectance[i]),
                    );
                    let cosine = sign * phase.cos();
                    (a + b - 2.0 * r * cosine) / (1.0 + r * r - 2.0 * r * cosine)
                };
                let matching = glam::DVec3::from(*matching);
                sum += matching * (0.5 * (part(0) + part(1)));
                whole += matching;
            }
            let space = WorkingSpace::Rec709.from_xyz();
            let expected = ((space * sum) / (space * whole)).as_vec3();
            let found = film.over_dielectric(cos, 1.5, Vec3::splat(0.04));
            assert!(
                (found - expected).abs().max_element() < 1e-3,
                "{found} {expected}"
            );
        }
    }
}
