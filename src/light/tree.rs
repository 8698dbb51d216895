//! A tree over all finite emitters: one is drawn by its estimated contribution to a point
//! (Conty Estevez and Kulla, *Importance Sampling of Many Lights with Adaptive Tree Splitting*,
//! HPG 2018; bounds of angles without trigonometry as in Pharr, Jakob, Humphreys, 4th ed., §12.6.3).

use crate::math::float::gamma;
use glam::Vec3;

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
    /// Cosine of the cone of normals' half angle (−1: all directions).
    pub cos_normals: f32,
    /// Cosine of how far beyond its normal an emitter emits (0: a hemisphere; 1: not at all).
    pub cos_emission: f32,
    /// Emits to both sides.
    pub two_sided: bool,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
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
        let (axis, cos_normals) = union_of_cones((a.axis, a.cos_normals), (b.axis, b.cos_normals));
        Self {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
            intensity: a.intensity + b.intensity,
            axis,
            cos_normals,
            cos_emission: a.cos_emission.min(b.cos_emission),
            two_sided: a.two_sided || b.two_sided,
        }
    }

    /// Estimate of the irradiance that the emitters send to a point: an upper bound of the angles,
    /// the middle for the distance. 0 only where nothing can arrive.
    #[inline]
    pub fn importance(&self, point: Vec3, normal: Option<Vec3>) -> f32 {
        let center = self.center();
        let to = center - point;
        let radius2 = ((self.max - self.min) * 0.5).length_squared();
        let d2_true = to.length_squared();
        // Inside the bounds all is possible, and the distance is of the size of the bounds.
        let d2 = d2_true.max(radius2).max(f32::MIN_POSITIVE);
        if d2_true <= radius2 * (1.0 + 1e-5) {
            return if self.is_averted(to) || normal.is_some_and(|n| self.is_below(to, n)) {
                0.0
            } else {
                self.intensity / d2
            };
        }
        let wi = to / d2_true.sqrt();
        let sin_b2 = radius2 / d2_true;
        let (sin_b, cos_b) = (sin_b2.sqrt(), (1.0 - sin_b2).max(0.0).sqrt());
        let mut cos_emitted = 1.0;
        if self.cos_normals > -1.0 {
            let mut cos_w = -self.axis.dot(wi);
            if self.two_sided {
                cos_w = cos_w.abs();
            }
            let (sin_w, sin_o) = (sin_from_cos(cos_w), sin_from_cos(self.cos_normals));
            let cos_x = cos_of_difference(sin_w, cos_w, sin_o, self.cos_normals);
            let sin_x = sin_of_difference(sin_w, cos_w, sin_o, self.cos_normals);
            cos_emitted = cos_of_difference(sin_x, cos_x, sin_b, cos_b);
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
            let cos_i = n.dot(wi);
            received = cos_of_difference(sin_from_cos(cos_i), cos_i, sin_b, cos_b);
            if received <= -ANGLE_MARGIN || (cos_i < 0.0 && self.is_below(to, n)) {
                return 0.0;
            }
            received = received.max(ANGLE_MARGIN);
        }
        self.intensity * cos_emitted * received / d2
    }
}

impl Bounds {
    /// Whether all emitters are flat and look the other way, by their box. (Wide sheets of lights, a ceiling or a wall of
    /// screens, have everything in the sphere around them, or nearly so.) `to`: from the point to the middle.
    #[inline]
    fn is_averted(&self, to: Vec3) -> bool {
        if self.cos_normals < 1.0 || self.cos_emission < 0.0 || self.two_sided {
            return false;
        }
        let half = (self.max - self.min) * 0.5;
        // How far before one of them the point may be; f32 holds cones of normals up to the margin for one direction.
        let before = self.axis.abs().dot(half) - self.axis.dot(to);
        before < -ANGLE_MARGIN * (to.length() + half.length())
    }

    /// Whether all emitters are below a surface's horizon, by their box.
    #[inline]
    fn is_below(&self, to: Vec3, normal: Vec3) -> bool {
        let half = (self.max - self.min) * 0.5;
        let above = normal.dot(to) + normal.abs().dot(half);
        // Three differences, three products, two sums.
        above < -gamma(8) * normal.abs().dot(to.abs() + half)
    }
}

/// Cosines above are differences of products of rounded sines: a sine of cosine c near 1 carries
/// an error of √(2·ε) ≈ 5e-4. Whatever lies within that of the bound still counts, so that no
/// light that can arrive has probability 0.
const ANGLE_MARGIN: f32 = 5e-4;

fn union_of_cones(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let (a, b) = if a.1 <= b.1 { (a, b) } else { (b, a) };
    if a.1 <= -1.0 {
        return (a.0, -1.0);
    }
    let (ta, tb) = (a.1.clamp(-1.0, 1.0).acos(), b.1.clamp(-1.0, 1.0).acos());
    let between = a.0.dot(b.0).clamp(-1.0, 1.0).acos();
    if between + tb <= ta {
        return a;
    }
    let half = 0.5 * (ta + tb + between);
    if half >= std::f32::consts::PI {
        return (a.0, -1.0);
    }
    let Some(across) = a.0.cross(b.0).try_normalize() else {
        return (a.0, -1.0);
    };
    let turn = half - ta;
    let (s, c) = turn.sin_cos();
    ((a.0 * c + across.cross(a.0) * s).normalize(), half.cos())
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
                bounds,
                index: emitter,
                leaf: true,
            });
            self.trails[emitter as usize] = trail;
            return bounds;
        }
        self.nodes.push(Node {
            bounds: emitters[order[0] as usize],
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
            bounds,
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
            .map_or(0.0, |n| n.bounds.importance(point, normal))
    }

    /// Draws an emitter.
    #[inline]
    pub fn sample(&self, point: Vec3, normal: Option<Vec3>, mut u: f32) -> Option<Choice> {
        let mut node = self.nodes.first()?;
        let mut at = 0usize;
        let mut probability = 1.0f32;
        while !node.leaf {
            let (a, b) = (&self.nodes[at + 1], &self.nodes[node.index as usize]);
            let first = first_share(a, b, point, normal)?;
            if u < first {
                u = (u / first).min(crate::math::float::ONE_MINUS_EPSILON);
                probability *= first;
                at += 1;
            } else {
                u = ((u - first) / (1.0 - first)).clamp(0.0, crate::math::float::ONE_MINUS_EPSILON);
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

/// Share of the first of two children; `None` if neither can send anything.
#[inline]
fn first_share(a: &Node, b: &Node, point: Vec3, normal: Option<Vec3>) -> Option<f32> {
    let (ia, ib) = (
        a.bounds.importance(point, normal),
        b.bounds.importance(point, normal),
    );
    let sum = ia + ib;
    if sum <= 0.0 {
        return None;
    }
    // Infinite estimates (emitters of 1e38) share alike.
    Some(if sum.is_finite() { ia / sum } else { 0.5 })
}

/// Surface area and orientation measure of bounds (Conty Estevez and Kulla, eq. 1).
fn measure(b: &Bounds) -> f32 {
    let d = b.max - b.min;
    let area = (d.x * d.y + d.y * d.z + d.z * d.x).max(d.length_squared() * 1e-3);
    let o = b.cos_normals.clamp(-1.0, 1.0).acos();
    let w = (o + b.cos_emission.clamp(-1.0, 1.0).acos()).min(std::f32::consts::PI);
    let orientation = std::f32::consts::TAU * (1.0 - o.cos())
        + std::f32::consts::FRAC_PI_2
            * (2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos());
    b.intensity * area * orientation.max(1e-3)
}

/// Sorts `order` so that a good split is before the returned place.
fn split(emitters: &[Bounds], order: &mut [u32]) -> usize {
    const BINS: usize = 12;
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
        let join = |range: &[Option<Bounds>]| {
            range
                .iter()
                .flatten()
                .copied()
                .reduce(|a, b| Bounds::union(&a, &b))
        };
        for cut in 1..BINS {
            // Behind an empty bin the cut is the one before it.
            if bins[cut - 1].is_none() {
                continue;
            }
            if let (Some(a), Some(b)) = (join(&bins[..cut]), join(&bins[cut..])) {
                // Long thin boxes are cut across: the factor of the paper's §4.4.
                let cost = (measure(&a) + measure(&b)) * longest / extent[axis];
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
    order.sort_by(|&a, &b| center(a)[axis].total_cmp(&center(b)[axis]).then(a.cmp(&b)));
    let middle = order.partition_point(|&i| center(i)[axis] < cut);
    if middle == 0 || middle == order.len() {
        order.len() / 2
    } else {
        middle
    }
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
                    cos_normals: if sphere { -1.0 } else { 1.0 },
                    cos_emission: 0.0,
                    two_sided: i % 2 == 0,
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
                let cos_emitted = if light.cos_normals < 0.0 {
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
