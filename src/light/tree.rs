//! A tree over all finite emitters: one is drawn by its estimated contribution to a point
//! (Conty Estevez and Kulla, *Importance Sampling of Many Lights with Adaptive Tree Splitting*,
//! HPG 2018; bounds of angles without trigonometry as in Pharr, Jakob, Humphreys, 4th ed., §12.6.3).

use crate::math::float::gamma;
use crate::sampler;
use glam::Vec3;

/// An angle of 0 to π. Both are kept, as a sine that is computed from a cosine near 1 has no digits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle {
    /// Its sine.
    pub sin: f32,
    /// Its cosine.
    pub cos: f32,
}

impl Angle {
    /// One direction.
    pub const ZERO: Self = Self { sin: 0.0, cos: 1.0 };
    /// All directions.
    pub const ALL: Self = Self {
        sin: 0.0,
        cos: -1.0,
    };

    fn radians(self) -> f32 {
        // Most often it is one of these, and an arc tangent takes as long as all else of a union.
        if self == Self::ZERO {
            0.0
        } else {
            self.sin.atan2(self.cos)
        }
    }

    fn from_radians(angle: f32) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos }
    }
}

/// What the tree knows of an emitter.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Lower corner.
    pub min: Vec3,
    /// Upper corner.
    pub max: Vec3,
    /// Radiant intensity in the brightest direction (luminance).
    pub intensity: f32,
    /// Middle of the cone of normals.
    pub axis: Vec3,
    /// Half angle of the cone of normals.
    pub normals: Angle,
    /// Cosine of how far beyond its normal an emitter emits (0: a hemisphere; 1: not at all).
    pub cos_emission: f32,
    /// Emits to both sides.
    pub two_sided: bool,
    /// The side of a plane from which alone it can be seen.
    pub front: Option<Front>,
}

/// One side of a plane: its normal, and how far along that it is.
#[derive(Clone, Copy, Debug)]
pub struct Front {
    /// Unit normal.
    pub normal: Vec3,
    /// Of a point in the plane, along the normal.
    pub offset: f32,
}

impl Front {
    /// Whether a point is on the other side, but for rounding: seen from as near to its plane as that, a light has next to no
    /// solid angle.
    #[inline]
    pub fn is_behind(&self, point: Vec3) -> bool {
        self.normal.dot(point) <= self.offset
    }
}

/// Bounds as estimates read them: by the middle of the box and half of its diagonal.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    center: Vec3,
    half: Vec3,
    intensity: f32,
    axis: Vec3,
    normals: Angle,
    cos_emission: f32,
    two_sided: bool,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    extent: Extent,
    /// The second child, or the emitter of a leaf.
    index: u32,
    leaf: bool,
}

/// The tree.
#[derive(Debug, Default)]
pub struct Tree {
    nodes: Vec<Node>,
    /// For each emitter the turns from the root to its leaf, lowest bit first.
    trails: Vec<u64>,
}

/// A chosen emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Its number.
    pub emitter: u32,
    /// Probability.
    pub probability: f32,
}

/// cos(max(0, a − b)) from sines and cosines of angles in 0..π.
#[inline]
fn cos_of_difference(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> f32 {
    if cos_a > cos_b {
        1.0
    } else {
        cos_a * cos_b + sin_a * sin_b
    }
}

/// sin(max(0, a − b)).
#[inline]
fn sin_of_difference(sin_a: f32, cos_a: f32, sin_b: f32, cos_b: f32) -> f32 {
    if cos_a > cos_b {
        0.0
    } else {
        sin_a * cos_b - cos_a * sin_b
    }
}

#[inline]
fn sin_from_cos(cos: f32) -> f32 {
    (1.0 - cos * cos).max(0.0).sqrt()
}

impl Bounds {
    fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    fn union(a: &Self, b: &Self) -> Self {
        let (axis, normals) = union_of_cones((a.axis, a.normals), (b.axis, b.normals));
        Self {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
            intensity: a.intensity + b.intensity,
            axis,
            normals,
            cos_emission: a.cos_emission.min(b.cos_emission),
            two_sided: a.two_sided || b.two_sided,
            front: None,
        }
    }

    /// For estimates.
    pub fn extent(&self) -> Extent {
        Extent {
            center: self.center(),
            half: (self.max - self.min) * 0.5,
            intensity: self.intensity,
            axis: self.axis,
            normals: self.normals,
            cos_emission: self.cos_emission,
            two_sided: self.two_sided,
        }
    }
}

impl Extent {
    /// Estimate of the irradiance that the emitters send to a point: an upper bound of the angles,
    /// the middle for the distance. 0 only where nothing can arrive.
    #[inline]
    pub fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        let to = self.center - point;
        let radius2 = self.half.length_squared();
        let d2 = to.length_squared();
        // Inside the bounds all is possible, and the distance is of the size of the bounds.
        if d2 <= radius2 * (1.0 + 1e-5) {
            return if self.is_averted(to) || normal.is_some_and(|n| self.is_below(to, n)) {
                0.0
            } else {
                self.intensity / d2.max(radius2).max(f32::MIN_POSITIVE)
            };
        }
        let per_d2 = 1.0 / d2.max(f32::MIN_POSITIVE);
        let per_d = per_d2.sqrt();
        let sphere = Sphere::seen_by(radius2 * per_d2);
        let mut cos_emitted = 1.0;
        if self.normals.cos > -1.0 {
            let mut cos_w = -self.axis.dot(to) * per_d;
            if self.two_sided {
                cos_w = cos_w.abs();
            }
            cos_emitted = if self.normals.cos == 1.0 {
                sphere.nearest_cosine(cos_w)
            } else {
                let (sin_w, Angle { sin, cos }) = (sin_from_cos(cos_w), self.normals);
                let cos_x = cos_of_difference(sin_w, cos_w, sin, cos);
                let sin_x = sin_of_difference(sin_w, cos_w, sin, cos);
                cos_of_difference(sin_x, cos_x, sphere.sin2.sqrt(), sphere.cos)
            };
            if cos_emitted <= self.cos_emission - ANGLE_MARGIN {
                return 0.0;
            }
            // Only by the size of the sphere: the box may know better.
            if cos_w < 0.0 && self.is_averted(to) {
                return 0.0;
            }
            cos_emitted = cos_emitted.max(ANGLE_MARGIN);
        }
        let mut received = 1.0;
        if let Some(n) = normal {
            let cos_i = n.dot(to) * per_d;
            received = sphere.nearest_cosine(cos_i);
            if received <= -ANGLE_MARGIN || (cos_i < 0.0 && self.is_below(to, n)) {
                return 0.0;
            }
            received = received.max(ANGLE_MARGIN);
        }
        self.intensity * cos_emitted * received * per_d2
    }

    /// Whether all emitters are flat and look the other way, by their box. (Wide sheets of lights, a ceiling or a wall of
    /// screens, have everything in the sphere around them, or nearly so.) `to`: from the point to the middle.
    #[inline]
    fn is_averted(&self, to: Vec3) -> bool {
        if self.normals.cos < 1.0 || self.cos_emission < 0.0 || self.two_sided {
            return false;
        }
        // How far before one of them the point may be; f32 holds cones of normals up to the margin for one direction.
        let before = self.axis.abs().dot(self.half) - self.axis.dot(to);
        before < -ANGLE_MARGIN * (to.length() + self.half.length())
    }

    /// Whether all emitters are below a surface's horizon, by their box.
    #[inline]
    fn is_below(&self, to: Vec3, normal: Vec3) -> bool {
        let above = normal.dot(to) + normal.abs().dot(self.half);
        // Three differences, three products, two sums.
        above < -gamma(8) * normal.abs().dot(to.abs() + self.half)
    }
}

/// The sphere about a box as a point outside of it sees it: half its angle.
struct Sphere {
    sin2: f32,
    cos: f32,
}

impl Sphere {
    #[inline]
    fn seen_by(sin2: f32) -> Self {
        Self {
            sin2,
            cos: (1.0 - sin2).max(0.0).sqrt(),
        }
    }

    /// The greatest cosine of directions into the sphere with one that has this cosine with its middle.
    #[inline]
    fn nearest_cosine(&self, cos: f32) -> f32 {
        if cos > self.cos {
            1.0
        } else {
            cos * self.cos + ((1.0 - cos * cos).max(0.0) * self.sin2).sqrt()
        }
    }
}

/// Cosines above are differences of products of rounded sines: a sine of cosine c near 1 carries
/// an error of √(2·ε) ≈ 5e-4. Whatever lies within that of the bound still counts, so that no
/// light that can arrive has probability 0.
const ANGLE_MARGIN: f32 = 5e-4;

/// By arc tangents: the arc cosine of two axes that differ by a rounding is 0 or 3.5e-4, as it rounds.
fn union_of_cones(a: (Vec3, Angle), b: (Vec3, Angle)) -> (Vec3, Angle) {
    let (a, b) = if a.1.cos <= b.1.cos { (a, b) } else { (b, a) };
    if a.1.cos <= -1.0 {
        return (a.0, Angle::ALL);
    }
    if a.0 == b.0 {
        return a;
    }
    let (ta, tb) = (a.1.radians(), b.1.radians());
    let across = a.0.cross(b.0);
    let between = across.length().atan2(a.0.dot(b.0));
    if between + tb <= ta {
        return a;
    }
    let half = 0.5 * (ta + tb + between);
    if half >= std::f32::consts::PI {
        return (a.0, Angle::ALL);
    }
    let Some(across) = across.try_normalize() else {
        return (a.0, Angle::ALL);
    };
    let (s, c) = (half - ta).sin_cos();
    let middle = (a.0 * c + across.cross(a.0) * s).normalize();
    (middle, Angle::from_radians(half))
}

impl Tree {
    /// Builds the tree over emitters 0, 1, 2, …
    pub fn new(emitters: &[Bounds]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(2 * emitters.len()),
            trails: vec![0; emitters.len()],
        };
        let mut order: Vec<u32> = (0..emitters.len() as u32).collect();
        if !emitters.is_empty() {
            tree.build(emitters, &mut order, 0, 0);
        }
        tree
    }

    fn build(&mut self, emitters: &[Bounds], order: &mut [u32], trail: u64, depth: u32) -> Bounds {
        let at = self.nodes.len();
        if let [emitter] = *order {
            let bounds = emitters[emitter as usize];
            self.nodes.push(Node {
                extent: bounds.extent(),
                index: emitter,
                leaf: true,
            });
            self.trails[emitter as usize] = trail;
            return bounds;
        }
        self.nodes.push(Node {
            extent: emitters[order[0] as usize].extent(),
            index: 0,
            leaf: false,
        });
        // A 64-bit trail holds 64 turns: halve where the cost would go on splitting off one by one.
        let middle = if depth < 30 {
            split(emitters, order)
        } else {
            halve(emitters, order)
        };
        let (left, right) = order.split_at_mut(middle);
        let a = self.build(emitters, left, trail, depth + 1);
        let second = self.nodes.len() as u32;
        let b = self.build(emitters, right, trail | 1 << depth, depth + 1);
        let bounds = Bounds::union(&a, &b);
        self.nodes[at] = Node {
            extent: bounds.extent(),
            index: second,
            leaf: false,
        };
        bounds
    }

    /// Whether there are no emitters.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Estimate for all emitters together.
    #[inline]
    pub fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        self.nodes
            .first()
            .map_or(0.0, |n| n.extent.importance(point, normal))
    }

    /// Draws an emitter.
    #[inline]
    pub fn sample(&self, point: Vec3, normal: Option<Vec3>, u: f32) -> Option<Choice> {
        let mut node = self.nodes.first()?;
        let mut at = 0usize;
        let mut probability = 1.0f32;
        let mut u = if node.leaf { 0.0 } else { finer(u, point) };
        while !node.leaf {
            let (a, b) = (&self.nodes[at + 1], &self.nodes[node.index as usize]);
            let first = first_share(a, b, point, normal)?;
            let share = f64::from(first);
            if u < share {
                u /= share;
                probability *= first;
                at += 1;
            } else {
                u = (u - share) / (1.0 - share);
                probability *= 1.0 - first;
                at = node.index as usize;
            }
            node = &self.nodes[at];
        }
        (probability > 0.0).then_some(Choice {
            emitter: node.index,
            probability,
        })
    }

    /// Probability with which [`Self::sample`] draws an emitter.
    #[inline]
    pub fn probability(&self, emitter: u32, point: Vec3, normal: Option<Vec3>) -> f32 {
        let mut trail = self.trails[emitter as usize];
        let mut at = 0usize;
        let mut probability = 1.0f32;
        while !self.nodes[at].leaf {
            let node = &self.nodes[at];
            let (a, b) = (&self.nodes[at + 1], &self.nodes[node.index as usize]);
            let Some(first) = first_share(a, b, point, normal) else {
                return 0.0;
            };
            if trail & 1 == 0 {
                probability *= first;
                at += 1;
            } else {
                probability *= 1.0 - first;
                at = node.index as usize;
            }
            trail >>= 1;
        }
        probability
    }
}

/// A number of 24 bits, drawn for a point, with 24 more. Twenty turns to one of a million lights would leave four bits for
/// the last of them: some lights would be drawn 6 % more often than told. The digits of the point alone count, not its
/// exponents, so that a scene that is scaled by a power of two keeps its bits.
#[inline]
fn finer(u: f32, point: Vec3) -> f64 {
    const STEP: f64 = 1.0 / 16_777_216.0;
    let digits = |x: f32| x.to_bits() & 0x007f_ffff;
    let below = sampler::hashed(
        u.to_bits() ^ digits(point.z),
        digits(point.x),
        digits(point.y),
    );
    f64::from(u) + f64::from(below) * STEP
}

/// What each of two children that may shine gets at least. An estimate knows nothing of what stands between: a lamp 10⁸ times
/// as strong behind a wall would keep all samples from the one in the room. So the variance is at most 2^10 times
/// that of the light alone, at each turn, and the other child's greater by a thousandth (defensive importance
/// sampling: Hesterberg, *Weighted Average Importance Sampling and Defensive Mixture Distributions*, 1995).
pub const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// Share of the first of two children; `None` if neither can send anything.
#[inline]
fn first_share(a: &Node, b: &Node, point: Vec3, normal: Option<Vec3>) -> Option<f32> {
    let (ia, ib) = (
        a.extent.importance(point, normal),
        b.extent.importance(point, normal),
    );
    let sum = ia + ib;
    if sum <= 0.0 {
        return None;
    }
    Some(if ia <= 0.0 {
        0.0
    } else if ib <= 0.0 {
        1.0
    } else if sum.is_finite() {
        (ia / sum).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
    } else {
        // Infinite estimates (emitters of 1e38) share alike.
        0.5
    })
}

/// Surface area and orientation measure of bounds (Conty Estevez and Kulla, eq. 1).
fn measure(b: &Bounds) -> f32 {
    let d = b.max - b.min;
    let area = (d.x * d.y + d.y * d.z + d.z * d.x).max(d.length_squared() * 1e-3);
    let (o, Angle { sin, cos }) = (b.normals.radians(), b.normals);
    let w = (o + b.cos_emission.clamp(-1.0, 1.0).acos()).min(std::f32::consts::PI);
    let orientation = std::f32::consts::TAU * (1.0 - cos)
        + std::f32::consts::FRAC_PI_2 * (2.0 * w * sin - (o - 2.0 * w).cos() - 2.0 * o * sin + cos);
    b.intensity * area * orientation.max(1e-3)
}

/// Orders `order` so that a good split is before the returned place.
fn split(emitters: &[Bounds], order: &mut [u32]) -> usize {
    const BINS: usize = 12;
    if order.len() == 2 {
        return 1;
    }
    let center = |i: u32| emitters[i as usize].center();
    let (min, max) = order
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), &i| {
            (lo.min(center(i)), hi.max(center(i)))
        });
    let extent = max - min;
    let longest = extent.max_element();
    let mut best: Option<(f32, usize, f32)> = None;
    for axis in 0..3 {
        if extent[axis] <= 0.0 || !extent[axis].is_finite() {
            continue;
        }
        let bin = |i: u32| {
            (((center(i)[axis] - min[axis]) / extent[axis] * BINS as f32) as usize).min(BINS - 1)
        };
        let mut bins: [Option<Bounds>; BINS] = [None; BINS];
        for &i in order.iter() {
            let b = &emitters[i as usize];
            let slot = &mut bins[bin(i)];
            *slot = Some(slot.map_or(*b, |s| Bounds::union(&s, b)));
        }
        // What lies before each cut, and behind it.
        let before = running(bins.iter());
        let behind = running(bins.iter().rev());
        for cut in 1..BINS {
            // Behind an empty bin the cut is the one before it.
            if bins[cut - 1].is_none() {
                continue;
            }
            if let (Some(a), Some(b)) = (&before[cut - 1], &behind[BINS - 1 - cut]) {
                // Long thin boxes are cut across: the factor of the paper's §4.4.
                let cost = (measure(a) + measure(b)) * longest / extent[axis];
                if best.is_none_or(|x| cost < x.0) {
                    best = Some((
                        cost,
                        axis,
                        min[axis] + extent[axis] * cut as f32 / BINS as f32,
                    ));
                }
            }
        }
    }
    let Some((_, axis, cut)) = best else {
        return halve(emitters, order);
    };
    let (left, right): (Vec<u32>, Vec<u32>) = order.iter().partition(|&&i| center(i)[axis] < cut);
    if left.is_empty() || right.is_empty() {
        return halve(emitters, order);
    }
    let (first, second) = order.split_at_mut(left.len());
    first.copy_from_slice(&left);
    second.copy_from_slice(&right);
    left.len()
}

/// The union of the first one, of the first two, and so on.
fn running<'a>(bins: impl Iterator<Item = &'a Option<Bounds>>) -> Vec<Option<Bounds>> {
    bins.scan(None, |all: &mut Option<Bounds>, bin| {
        *all = match (*all, bin) {
            (Some(all), Some(bin)) => Some(Bounds::union(&all, bin)),
            (None, one) => *one,
            (some, None) => some,
        };
        Some(*all)
    })
    .collect()
}

/// Cuts at the median of the longest axis.
fn halve(emitters: &[Bounds], order: &mut [u32]) -> usize {
    let center = |i: u32| emitters[i as usize].center();
    let (min, max) = order
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), &i| {
            (lo.min(center(i)), hi.max(center(i)))
        });
    let d = max - min;
    let axis = if d.x >= d.y && d.x >= d.z {
        0
    } else if d.y >= d.z {
        1
    } else {
        2
    };
    order.sort_by(|&a, &b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(&b)));
    order.len() / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    fn emitters(n: usize) -> Vec<Bounds> {
        (0..n)
            .map(|i| {
                let r = |k: u32| crate::sampler::hashed(k, i as u32, 17);
                let center = Vec3::new(r(1), r(2), r(3)) * 20.0 - 10.0;
                let sphere = i % 3 == 0;
                let axis = (Vec3::new(r(4), r(5), r(6)) - 0.5).normalize();
                Bounds {
                    min: center - 0.1,
                    max: center + 0.1,
                    intensity: r(7) * 10.0 + 0.01,
                    axis,
                    normals: if sphere { Angle::ALL } else { Angle::ZERO },
                    cos_emission: 0.0,
                    two_sided: i % 2 == 0,
                    front: None,
                }
            })
            .collect()
    }

    #[test]
    fn probabilities_sum_to_one_and_agree_with_the_draws() {
        let lights = emitters(300);
        let tree = Tree::new(&lights);
        for (point, normal) in [
            (Vec3::new(1.0, 2.0, 3.0), Some(Vec3::Y)),
            (Vec3::new(-30.0, 0.0, 0.0), None),
            (lights[7].center(), Some(Vec3::X)),
        ] {
            let sum: f64 = (0..300)
                .map(|i| f64::from(tree.probability(i, point, normal)))
                .sum();
            let n = 20_000;
            let mut drawn = 0f64;
            for k in 0..n {
                // A node whose bounds promise light may have children that can't send any: then
                // nothing is drawn, and the probabilities sum to less than 1.
                let Some(choice) = tree.sample(point, normal, (k as f32 + 0.5) / n as f32) else {
                    continue;
                };
                drawn += 1.0 / f64::from(n);
                let expected = tree.probability(choice.emitter, point, normal);
                assert!((choice.probability / expected - 1.0).abs() < 1e-5);
            }
            // Each of at most 300 emitters may lose one of the 20,000 strata at its ends.
            assert!((sum - drawn).abs() < 300.0 / f64::from(n), "{sum} {drawn}");
            // Half of the space is below the horizon and a third of the emitters face one way:
            // clusters promise about twice what they hold (0.48 at the first point).
            assert!(drawn > 0.4, "{drawn} {sum} at {point}");
        }
    }

    /// No emitter that can light a point has probability 0: sampled points on emitters that see
    /// the receiver are compared with the estimate.
    #[test]
    fn what_can_arrive_can_be_drawn() {
        let lights = emitters(400);
        let tree = Tree::new(&lights);
        for k in 0..400u32 {
            let r = |j: u32| crate::sampler::hashed(j, k, 99);
            let point = Vec3::new(r(1), r(2), r(3)) * 30.0 - 15.0;
            let normal = (Vec3::new(r(4), r(5), r(6)) - 0.5).normalize();
            for (i, light) in lights.iter().enumerate() {
                let on = light.center() + (Vec3::new(r(7), r(8), r(9)) - 0.5) * 0.2;
                let wi = (on - point).normalize();
                let cos_emitted = if light.normals == Angle::ALL {
                    1.0
                } else if light.two_sided {
                    light.axis.dot(wi).abs()
                } else {
                    -light.axis.dot(wi)
                };
                if wi.dot(normal) > 0.0 && cos_emitted > 0.0 {
                    assert!(
                        tree.probability(i as u32, point, Some(normal)) > 0.0,
                        "{k} {i}"
                    );
                }
            }
        }
    }

    /// However strong the other one is, a light that may shine is drawn once in 1024 times.
    #[test]
    fn no_light_starves_beside_a_stronger_one() {
        let at = |x: f32, intensity: f32| Bounds {
            min: Vec3::new(x, 0.0, 0.0),
            max: Vec3::new(x, 0.0, 0.0),
            intensity,
            axis: Vec3::Z,
            normals: Angle::ALL,
            cos_emission: 1.0,
            two_sided: false,
            front: None,
        };
        for stronger in [1e4, 1e8, 1e30] {
            let tree = Tree::new(&[at(-1.0, stronger), at(1.0, 1.0)]);
            let sum = tree.probability(0, Vec3::ZERO, None) + tree.probability(1, Vec3::ZERO, None);
            assert!((sum - 1.0).abs() < 1e-6);
            let n = 1 << 16;
            let weak = (0..n)
                .filter_map(|k| tree.sample(Vec3::ZERO, None, k as f32 / n as f32))
                .filter(|choice| choice.emitter == 1)
                .inspect(|choice| assert_eq!(choice.probability, LEAST_SHARE))
                .count();
            assert_eq!(weak, n >> 10);
        }
    }

    /// Between a number of 24 bits and the next, and the same for a scene of twice the size.
    #[test]
    fn finer_numbers_stay_in_their_cell() {
        for k in 0..1000u32 {
            let r = |j: u32| sampler::hashed(j, k, 5);
            let (u, point) = (r(0), Vec3::new(r(1), -r(2), r(3)));
            let finer_u = finer(u, point);
            let cell = f64::from(u)..f64::from(u) + 1.0 / 16_777_216.0;
            assert!(cell.contains(&finer_u) && finer_u < 1.0);
            assert_eq!(finer_u, finer(u, point * 1024.0));
        }
    }

    #[test]
    fn many_lights_in_one_place_and_none_at_all_are_fine() {
        let one = emitters(1)[0];
        let tree = Tree::new(&vec![one; 5000]);
        let sum: f64 = (0..5000)
            .map(|i| f64::from(tree.probability(i, Vec3::ZERO, None)))
            .sum();
        assert!((sum - 1.0).abs() < 1e-3);
        assert!(Tree::new(&[]).sample(Vec3::ZERO, None, 0.5).is_none());
    }
}
