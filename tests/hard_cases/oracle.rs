//! The kernels in f32 against their own source in f64: how many units in the last place they are off.
//!
//! A rounding is half a unit in the last place of numbers just above a power of two: n roundings in a row, γ(n), are at most n
//! units. Where a kernel subtracts on purpose, its error is told in units of the larger term.

use super::{Case, Effort, Finding};
use glam::{DVec2, DVec3, Vec2, Vec3};
use sundog::light::lamp::Lamp;
use sundog::light::rectangle::SphericalRectangle;
use sundog::light::triangle::Triangle;
use sundog::math::warp;
use sundog::render::RenderError;
use sundog::sampler::hashed;
use sundog::shading::{fresnel, ggx};

/// The kernels in f64, made by build.rs of the same text.
#[allow(dead_code, missing_docs, unused_imports, clippy::all)]
pub(crate) mod double {
    include!(concat!(env!("OUT_DIR"), "/double.rs"));
}

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "fresnel-in-ulp",
        about: "Fresnel's reflectance for indices from 1 + 1e-7 to 1e4 from both sides, against f64.",
        run: dielectric,
    },
    Case {
        name: "ggx-in-ulp",
        about: "GGX: D, Smith's lambda and G for alpha from 1e-5 to 1 and views down to a cosine of 1e-7, against f64.",
        run: microfacets,
    },
    Case {
        name: "triangles-in-ulp",
        about: "Densities and directions of spherical triangles from 1e-4 to 1e6 of their size, against f64.",
        run: triangles,
    },
    Case {
        name: "rectangles-in-ulp",
        about: "Solid angles of spherical rectangles from 1e-4 to 1e6 of their size, against f64 by another formula.",
        run: rectangles,
    },
    Case {
        name: "spheres-in-ulp",
        about: "Cones of sphere lamps and hits of rays on them from 1.001 to 1e6 radii away, against f64.",
        run: spheres,
    },
];

/// The largest error so far, in units in the last place, and where.
#[derive(Default)]
struct Worst {
    ulp: f64,
    at: String,
    sum: f64,
    count: f64,
}

/// A unit in the last place of f32 for a number.
fn ulp(x: f64) -> f64 {
    let x = (x.abs() as f32).max(f32::MIN_POSITIVE);
    f64::from(x.next_up() - x)
}

impl Worst {
    /// A number and its true value; the error is told in units of `unit`.
    fn add(&mut self, found: f32, exact: f64, unit: f64, at: impl FnOnce() -> String) {
        let error = (f64::from(found) - exact).abs() / ulp(unit);
        self.sum += error;
        self.count += 1.0;
        // What is not a number stays the largest.
        if error.is_nan() || error > self.ulp {
            (self.ulp, self.at) = (error, at());
        }
    }

    fn finding(self, what: &str, bound: f64) -> Finding {
        let mean = self.sum / self.count;
        let place = format!("{} (mean {mean:.2})", self.at);
        Finding::at_most(format!("{what}: largest error in ulp"), bound, self.ulp).at(place)
    }
}

/// A number between two, evenly by its logarithm.
fn between(low: f32, high: f32, key: u32, number: u32) -> f32 {
    let t = f64::from(hashed(key, number, 77));
    (f64::from(low).ln() * (1.0 - t) + f64::from(high).ln() * t).exp() as f32
}

fn count(effort: Effort) -> u32 {
    effort.of(20_000, 500_000, 20_000_000)
}

/// Into the denser side: η² − 1 has 3 roundings, the root γ(3), sums and square γ(9), quotient γ(13), its square γ(27); the
/// parallel part has (η² + 1)cos² − 1, whose roundings γ(4) count as much as the larger term: seen from the other part, which is
/// never smaller than that, in the same units. From the denser side η² − sin²θ itself cancels toward the critical angle, where
/// reflectance has a vertical tangent and the input's last bit has as much to say: as far as g is at least half of the cosine,
/// (|η² − 1| + cos²)/g² is at most 8, and half of that goes through the root.
fn dielectric(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (mut outside, mut inside) = (Worst::default(), Worst::default());
    for i in 0..count(effort) {
        let cos = between(1e-7, 1.0, 1, i);
        let eta = 1.0 + between(1.2e-7, 1e4, 2, i);
        let found = fresnel::dielectric(cos, eta).reflectance;
        let exact =
            double::shading::fresnel::dielectric(f64::from(cos), f64::from(eta)).reflectance;
        outside.add(found, exact, exact, || {
            format!("index {eta}, cosine {cos:e}")
        });

        let eta = 1.0 / eta;
        let found = fresnel::dielectric(cos, eta).reflectance;
        let d = double::shading::fresnel::dielectric(f64::from(cos), f64::from(eta));
        let g = d.cos_t * f64::from(eta);
        if g > 0.5 * f64::from(cos) {
            inside.add(found, d.reflectance, d.reflectance, || {
                format!("index {eta}, cosine {cos:e}")
            });
        }
    }
    Ok(vec![
        outside.finding("from outside", 32.0),
        inside.finding(
            "from inside, up to where half of the cosine is left",
            32.0 * 4.0,
        ),
    ])
}

fn direction(i: u32, key: u32) -> Vec3 {
    let cos = between(1e-7, 1.0, key, i);
    let phi = std::f32::consts::TAU * hashed(key + 1, i, 3);
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// D: two squares and the sum γ(3) … α² and product γ(3), sum γ(4), its square γ(9), with π and the quotient γ(12). Λ: α² and the
/// sum of squares γ(5), root γ(4), sums and products γ(7), quotient γ(13). G2/cos: stretched length γ(4), sums and product
/// with Λ γ(16), quotient γ(17).
fn microfacets(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    use double::shading::ggx as exact;
    let [mut d, mut lambda, mut masking] = [(); 3].map(|()| Worst::default());
    for i in 0..count(effort) {
        let alpha = between(1.415e-5, 1.0, 5, i);
        let a = &exact::Alpha::isotropic(f64::from(alpha));
        let (width, alpha) = (alpha, &ggx::Alpha::isotropic(alpha));
        let (wo, wi) = (direction(i, 6), direction(i, 8));
        let at = || format!("alpha {width:e}, cosine {:e}", wo.z);
        d.add(
            ggx::d(wo, alpha),
            exact::d(wo.as_dvec3(), a),
            exact::d(wo.as_dvec3(), a),
            at,
        );
        let true_lambda = exact::lambda(wo.as_dvec3(), a);
        lambda.add(ggx::lambda(wo, alpha), true_lambda, true_lambda, at);
        let true_masking = exact::View::new(wo.as_dvec3(), a).g2_over_cos(wi.as_dvec3(), a);
        masking.add(
            ggx::View::new(wo, alpha).g2_over_cos(wi, alpha),
            true_masking,
            true_masking,
            at,
        );
    }
    Ok(vec![
        d.finding("D", 12.0),
        lambda.finding("lambda", 13.0),
        masking.finding("G over the view's cosine", 17.0),
    ])
}

/// A place over a light of size 1 at 1e-4 to 1e6 of its size, at angles to its plane from 1e-4 to upright.
fn over(i: u32, key: u32) -> Vec3 {
    let distance = between(1e-4, 1e6, key, i);
    let up = between(1e-4, 1.0, key + 1, i);
    let phi = std::f32::consts::TAU * hashed(key + 2, i, 4);
    let beside = ((1.0 - up) * (1.0 + up)).sqrt();
    let on = Vec3::new(
        hashed(key + 3, i, 5) - 0.5,
        hashed(key + 4, i, 6) - 0.5,
        0.0,
    );
    on + Vec3::new(beside * phi.cos(), beside * phi.sin(), -up) * distance
}

/// Near, all is done in f64 and rounded once. From afar the density is 2d³/|d·n| of a drawn point: its coordinates γ(4) of the
/// larger of light and distance, d² γ(7), d³ γ(11), the product with the normal γ(10) of its largest term, which at an angle of
/// 1e-4 to the plane is the density's 1e4-fold: told in units of density over the sine of that angle.
fn triangles(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (mut near, mut far, mut aside) = (Worst::default(), Worst::default(), Worst::default());
    let corners = [
        Vec3::new(-0.5, -0.5, 0.0),
        Vec3::new(0.5, -0.5, 0.0),
        Vec3::new(0.5, 0.5, 0.0),
    ];
    let shape = Triangle { corners };
    let exact = double::light::triangle::Triangle {
        corners: corners.map(|c| c.as_dvec3()),
    };
    for i in 0..count(effort) / 4 {
        let from = over(i, 30);
        let u = Vec2::new(hashed(40, i, 0), hashed(41, i, 0));
        let (Some(f), Some(e)) = (
            shape.sample(from, u),
            exact.sample(from.as_dvec3(), u.as_dvec2()),
        ) else {
            continue;
        };
        let at = || format!("{from}");
        let is_near = from.length() < 10.0;
        let worst = if is_near { &mut near } else { &mut far };
        worst.add(f.pdf, e.pdf, e.pdf, at);
        let off = (f.wi.as_dvec3() - e.wi).length();
        aside.add(off as f32, 0.0, 1.0, at);
    }
    Ok(vec![
        near.finding("density near", 1.0),
        far.finding("density from afar", 28.0),
        aside.finding("direction, in units of 1", 8.0),
    ])
}

/// The sum of two triangles by Van Oosterom and Strackee, from corners in f64.
fn rectangles(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut worst = Worst::default();
    for i in 0..count(effort) / 4 {
        let from = over(i, 50);
        let (low, high) = (DVec2::splat(-0.5), DVec2::splat(0.5));
        let foot = from.truncate().as_dvec2();
        let height = f64::from(-from.z);
        let Some(found) = SphericalRectangle::new(low - foot, high - foot, height) else {
            continue;
        };
        let corner = |x: f64, y: f64| DVec3::new(x - foot.x, y - foot.y, height);
        let corners = [
            corner(-0.5, -0.5),
            corner(0.5, -0.5),
            corner(0.5, 0.5),
            corner(-0.5, 0.5),
        ];
        let part = |a: usize, b: usize, c: usize| {
            double::light::spherical_triangle::SphericalTriangle::new([
                corners[a], corners[b], corners[c],
            ])
            .map_or(f64::NAN, |t| t.solid_angle())
        };
        let exact = part(0, 1, 2) + part(0, 2, 3);
        worst.add(found.solid_angle() as f32, exact, exact, || {
            format!("{from}")
        });
    }
    // Sums of angles of order 1 have 1e-15 of error; what is taken is at least 1e-10, 1e-5 of which are 84 units.
    Ok(vec![worst.finding("solid angle", 84.0)])
}

/// 1 − cos of the cone: squares and sum γ(3), quotient γ(7) for sin², and γ(9) for what follows; but cos² = 1 − sin² cancels near
/// the sphere, by γ(7)/(2 cosθ (1 + cosθ)) of the whole: 75 u at 1.001 radii, where cosθ is 0.045.
///
/// A hit, in units of the centre's distance d: b has γ(4), the foot of the perpendicular γ(5) of d, and the half chord
/// √(r² − foot²) feels that 0.9/√(1 − 0.9²) = 2.1-fold where rays stay within 0.9 radii: 4 + 2.1·5, and as much again of sums.
fn spheres(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let (mut cone, mut hit) = (Worst::default(), Worst::default());
    let mut missed = 0;
    for i in 0..count(effort) {
        let radii = 1.0 + between(1e-3, 1e6, 60, i);
        let axis = warp::sphere(Vec2::new(hashed(61, i, 0), hashed(62, i, 0)));
        let lamp = Lamp {
            center: axis * radii,
            radius: 1.0,
            soft_falloff: false,
            intensity: Vec3::ONE,
            cone: None,
        };
        let exact = double::light::lamp::Lamp {
            center: lamp.center.as_dvec3(),
            radius: 1.0,
            soft_falloff: false,
            intensity: DVec3::ONE,
            cone: None,
        };
        let u = Vec2::new(hashed(63, i, 0), hashed(64, i, 0)) * 0.9 + 0.05;
        let (Some(f), Some(e)) = (
            lamp.sample(Vec3::ZERO, None, u),
            exact.sample(DVec3::ZERO, None, u.as_dvec2()),
        ) else {
            missed += 1;
            continue;
        };
        let at = || format!("{radii} radii");
        cone.add(f.direction.pdf, e.direction.pdf, e.direction.pdf, at);
        // The same ray.
        let (Some(found), Some(true_hit)) = (
            lamp.hit(Vec3::ZERO, f.direction.wi),
            exact.hit(DVec3::ZERO, f.direction.wi.as_dvec3().normalize()),
        ) else {
            missed += 1;
            continue;
        };
        hit.add(found, true_hit, f64::from(radii), at);
    }
    Ok(vec![
        cone.finding("density of the cone", 84.0),
        hit.finding("distance of a hit, in units of the centre's", 20.0),
        Finding::none("rays that miss", missed),
    ])
}
