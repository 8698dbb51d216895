//! Blender's Voronoi Texture, after Inigo Quilez (iquilezles.org/articles/voronoilines, /smoothvoronoi).

mod cells;

use std::marker::PhantomData;

use glam::Vec3;
use pulp::NullaryFnOnce;

use super::{CyclesVersion, Dimensions, fused, mix, on_vectors};
use cells::{Cells, Cellular, Lookup3, Nearest, Pcg};

choice! {
    /// What is measured.
    VoronoiFeature {
        /// The nearest point.
        F1 = "F1",
        /// The second nearest point.
        F2 = "F2",
        /// The nearest point, with cells that flow into each other.
        SmoothF1 = "SMOOTH_F1",
        /// The distance to the nearest edge between two cells.
        DistanceToEdge = "DISTANCE_TO_EDGE",
        /// Half the way from the nearest point to its own nearest: spheres of this radius around the points touch.
        NSphereRadius = "N_SPHERE_RADIUS",
    }
}

choice! {
    /// How distances are measured. In one dimension all are the same.
    VoronoiMetric {
        /// The straight line.
        Euclidean = "EUCLIDEAN",
        /// The sum over the axes.
        Manhattan = "MANHATTAN",
        /// The greatest of the axes. The identifier is spelt as Blender does.
        Chebychev = "CHEBYCHEV",
        /// Between and beyond these, by the exponent.
        Minkowski = "MINKOWSKI",
    }
}

/// What puts points into cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VoronoiHash {
    /// Before 5.0: Bob Jenkins' lookup3.
    Lookup3,
    /// From 5.0 on: PCG hashes of vectors, which are faster.
    Pcg,
}

impl VoronoiHash {
    /// That of a version.
    pub fn of(version: CyclesVersion) -> Self {
        if version < CyclesVersion::new(5, 0) {
            Self::Lookup3
        } else {
            Self::Pcg
        }
    }
}

/// The node's menus and boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoronoiSettings {
    /// How many coordinates count.
    pub dimensions: Dimensions,
    /// What is measured.
    pub feature: VoronoiFeature,
    /// How; edges and spheres are measured by the straight line whatever it says.
    pub metric: VoronoiMetric,
    /// Whether distances are brought to 0..1.
    pub normalize: bool,
    /// What puts points into cells.
    pub hash: VoronoiHash,
}

/// The node's sockets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoronoiInputs {
    /// Vector.
    pub vector: Vec3,
    /// W, the coordinate of 1D and the fourth of 4D.
    pub w: f32,
    /// Scale, of the vector and of W.
    pub scale: f32,
    /// Detail, 0 to 15.
    pub detail: f32,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Lacunarity.
    pub lacunarity: f32,
    /// Smoothness, 0 to 1, of the smooth feature.
    pub smoothness: f32,
    /// Exponent, of Minkowski's metric.
    pub exponent: f32,
    /// Randomness, 0 to 1.
    pub randomness: f32,
}

impl Default for VoronoiInputs {
    fn default() -> Self {
        Self {
            vector: Vec3::ZERO,
            w: 0.0,
            scale: 5.0,
            detail: 0.0,
            roughness: 0.5,
            lacunarity: 2.0,
            smoothness: 1.0,
            exponent: 0.5,
            randomness: 1.0,
        }
    }
}

/// The node's outputs; those that a feature does not have are zero, as in Cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoronoiOutputs {
    /// Distance.
    pub distance: f32,
    /// Color of the cell.
    pub color: Vec3,
    /// Position of the cell's point.
    pub position: Vec3,
    /// W of the cell's point.
    pub w: f32,
    /// Radius.
    pub radius: f32,
}

/// Blender's Voronoi Texture.
pub fn voronoi(settings: &VoronoiSettings, inputs: &VoronoiInputs) -> VoronoiOutputs {
    match settings.hash {
        VoronoiHash::Pcg => hashed::<Pcg>(settings, inputs),
        VoronoiHash::Lookup3 => hashed::<Lookup3>(settings, inputs),
    }
}

/// The node, by a hash.
fn hashed<H>(settings: &VoronoiSettings, inputs: &VoronoiInputs) -> VoronoiOutputs
where
    H: Cellular<1> + Cellular<2> + Cellular<3> + Cellular<4>,
{
    let Vec3 { x, y, z } = inputs.vector * inputs.scale;
    let w = inputs.w * inputs.scale;
    match settings.dimensions {
        Dimensions::One => evaluate::<_, H>(settings, inputs, [w], [3]),
        Dimensions::Two => evaluate::<_, H>(settings, inputs, [x, y], [0, 1]),
        Dimensions::Three => evaluate::<_, H>(settings, inputs, [x, y, z], [0, 1, 2]),
        Dimensions::Four => evaluate::<_, H>(settings, inputs, [x, y, z, w], [0, 1, 2, 3]),
    }
}

/// The node in N dimensions; `axes` says which of X, Y, Z and W they are.
fn evaluate<const N: usize, H: Cellular<N>>(
    settings: &VoronoiSettings,
    inputs: &VoronoiInputs,
    p: [f32; N],
    axes: [usize; N],
) -> VoronoiOutputs {
    let fractal = Fractal {
        cells: Cells {
            randomness: inputs.randomness.clamp(0.0, 1.0),
            smoothness: (inputs.smoothness / 2.0).clamp(0.0, 0.5),
            metric: settings.metric,
            exponent: inputs.exponent,
            hash: PhantomData::<H>,
        },
        detail: inputs.detail.clamp(0.0, 15.0),
        roughness: inputs.roughness.clamp(0.0, 1.0),
        lacunarity: inputs.lacunarity,
        normalize: settings.normalize,
    };
    match settings.feature {
        VoronoiFeature::DistanceToEdge => VoronoiOutputs {
            distance: fractal.distance_to_edge(p),
            ..VoronoiOutputs::default()
        },
        VoronoiFeature::NSphereRadius => VoronoiOutputs {
            radius: on_vectors(Spheres(&fractal.cells, p)),
            ..VoronoiOutputs::default()
        },
        feature => {
            let nearest = fractal.nearest(feature, p);
            let mut point = [0.0; 4];
            if inputs.scale != 0.0 {
                for (axis, coordinate) in axes.into_iter().zip(nearest.position) {
                    point[axis] = coordinate / inputs.scale;
                }
            }
            let [x, y, z, w] = point;
            VoronoiOutputs {
                distance: nearest.distance,
                color: nearest.color,
                position: Vec3::new(x, y, z),
                w,
                radius: 0.0,
            }
        }
    }
}

/// What is nearest in one octave.
struct Octave<'a, const N: usize, H> {
    cells: &'a Cells<N, H>,
    feature: VoronoiFeature,
    p: [f32; N],
}

impl<const N: usize, H: Cellular<N>> NullaryFnOnce for Octave<'_, N, H> {
    type Output = Nearest<N>;

    #[inline(always)]
    fn call(self) -> Nearest<N> {
        let Self { cells, feature, p } = self;
        match feature {
            VoronoiFeature::F2 => cells.second_nearest(p),
            VoronoiFeature::SmoothF1 if cells.smoothness != 0.0 => cells.smooth(p),
            _ => cells.nearest(p),
        }
    }
}

/// The nearest edge in one octave.
struct EdgeOctave<'a, const N: usize, H>(&'a Cells<N, H>, [f32; N]);

impl<const N: usize, H: Cellular<N>> NullaryFnOnce for EdgeOctave<'_, N, H> {
    type Output = f32;

    #[inline(always)]
    fn call(self) -> f32 {
        self.0.distance_to_edge(self.1)
    }
}

/// The radius of spheres that touch.
struct Spheres<'a, const N: usize, H>(&'a Cells<N, H>, [f32; N]);

impl<const N: usize, H: Cellular<N>> NullaryFnOnce for Spheres<'_, N, H> {
    type Output = f32;

    #[inline(always)]
    fn call(self) -> f32 {
        self.0.sphere_radius(self.1)
    }
}

/// Octaves of cells, each finer and weaker than the one before it.
struct Fractal<const N: usize, H> {
    cells: Cells<N, H>,
    detail: f32,
    roughness: f32,
    lacunarity: f32,
    normalize: bool,
}

impl<const N: usize, H: Cellular<N>> Fractal<N, H> {
    /// Whether the first octave is all there is.
    fn is_single(&self) -> bool {
        self.detail == 0.0 || self.roughness == 0.0
    }

    /// How much octave `number` counts: wholly, in part after the last whole one.
    fn share(&self, number: i32) -> f32 {
        if number as f32 <= self.detail {
            1.0
        } else {
            self.detail - self.detail.floor()
        }
    }

    /// Distances of F1, F2 and the smooth F1 are added like fractal noise, points are mixed.
    fn nearest(&self, feature: VoronoiFeature, p: [f32; N]) -> Nearest<N> {
        let octave = |scale: f32| {
            let p = p.map(|x| x * scale);
            let cells = &self.cells;
            on_vectors(Octave { cells, feature, p })
        };
        let mut result;
        let mut greatest;
        if self.is_single() {
            result = octave(1.0);
            greatest = 1.0;
        } else {
            result = Nearest::default();
            greatest = 0.0;
            let mut amplitude = 1.0;
            let mut scale = 1.0;
            for number in 0..=self.detail.ceil() as i32 {
                let found = octave(scale);
                let share = self.share(number);
                let sum = fused(found.distance, amplitude, result.distance);
                result.distance = partly(result.distance, sum, share);
                let sum = result.color + found.color * amplitude;
                result.color = if share == 1.0 {
                    sum
                } else {
                    mix(result.color, sum, share)
                };
                for (mixed, new) in result.position.iter_mut().zip(found.position) {
                    *mixed = partly(*mixed, mix(*mixed, new / scale, amplitude), share);
                }
                greatest = partly(greatest, greatest + amplitude, share);
                scale *= self.lacunarity;
                amplitude *= self.roughness;
            }
        }
        if self.normalize {
            result.distance /= greatest * self.greatest_distance(feature);
            result.color /= greatest;
        }
        result
    }

    /// What the distance may be at most.
    fn greatest_distance(&self, feature: VoronoiFeature) -> f32 {
        let middle = [0.5 + 0.5 * self.cells.randomness; N];
        let distance = self.cells.distance([0.0; N], middle);
        if feature == VoronoiFeature::F2 {
            distance * 2.0
        } else {
            distance
        }
    }

    /// The nearest edge of any octave, each counting by its amplitude.
    fn distance_to_edge(&self, p: [f32; N]) -> f32 {
        // More than any distance in a lattice of unit cells.
        const FAR: f32 = 8.0;
        let most = 0.5 + 0.5 * self.cells.randomness;
        let mut greatest = most;
        let mut distance = FAR;
        if self.is_single() {
            distance = on_vectors(EdgeOctave(&self.cells, p));
        } else {
            let mut amplitude = 1.0;
            let mut scale = 1.0;
            for number in 0..=self.detail.ceil() as i32 {
                let found = on_vectors(EdgeOctave(&self.cells, p.map(|x| x * scale)));
                let share = self.share(number);
                let nearer = mix(distance, distance.min(found / scale), amplitude);
                distance = if share == 1.0 {
                    nearer
                } else {
                    mix(distance, distance.min(nearer), share)
                };
                greatest = partly(greatest, mix(greatest, most / scale, amplitude), share);
                scale *= self.lacunarity;
                amplitude *= self.roughness;
            }
        }
        if self.normalize {
            distance /= greatest;
        }
        distance
    }
}

/// `new` where it counts wholly, a mix with `old` where it counts in part.
fn partly(old: f32, new: f32, share: f32) -> f32 {
    if share == 1.0 {
        new
    } else {
        mix(old, new, share)
    }
}
