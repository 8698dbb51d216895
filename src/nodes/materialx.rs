//! Noises of MaterialX' standard library that Blender's textures do not have: cells, Worley's distances, and Perlin's noise of three
//! numbers at once. The lattice, its hashes and its gradients are those of Blender's textures: both have them from OSL.

use glam::Vec3;

use super::{hash, perlin};

/// A noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LatticeNoise {
    /// A number for each cell.
    Cell,
    /// Distances to the nearest points, of which each cell has one.
    Worley,
    /// Numbers of the cell whose point is nearest.
    WorleyCell,
    /// Perlin's noise of three numbers, by other bits of one hash: octaves of it.
    Perlin,
}

/// Which one, and of how many coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LatticeSettings {
    /// Which.
    pub noise: LatticeNoise,
    /// The third coordinate does not count.
    pub flat: bool,
}

/// What it is asked of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeInputs {
    /// The place.
    pub vector: Vec3,
    /// How far points are from the middles of their cells, 0 to 1.
    pub jitter: f32,
    /// Octaves of Perlin's noise.
    pub octaves: f32,
    /// The frequency of each beside the one before it.
    pub lacunarity: f32,
    /// The amplitude of each beside the one before it.
    pub diminish: f32,
}

/// More octaves are beyond what floats tell apart.
const MOST_OCTAVES: f32 = 32.0;

/// Three numbers, and one: of a cell its number, of distances the least.
pub fn lattice_noise(settings: LatticeSettings, inputs: &LatticeInputs) -> (Vec3, f32) {
    let flat = settings.flat;
    match settings.noise {
        LatticeNoise::Cell => {
            let value = cell_number(cell_of(inputs.vector), flat);
            (Vec3::splat(value), value)
        }
        LatticeNoise::Worley | LatticeNoise::WorleyCell => {
            let (distances, nearest) = nearest_points(inputs.vector, inputs.jitter, flat);
            if settings.noise == LatticeNoise::Worley {
                return (distances, distances.x);
            }
            let cell = cell_of(nearest);
            (cell_numbers(cell, flat), cell_number(cell, flat))
        }
        LatticeNoise::Perlin => {
            let (mut sum, mut amplitude, mut at) = (Vec3::ZERO, 1.0, inputs.vector);
            for _ in 0..inputs.octaves.clamp(0.0, MOST_OCTAVES) as u32 {
                sum += amplitude * perlin::three(at, flat);
                amplitude *= inputs.diminish;
                at *= inputs.lacunarity;
            }
            (sum, sum.x)
        }
    }
}

/// The words of a cell.
fn cell_of(place: Vec3) -> [u32; 3] {
    place.to_array().map(|x| x.floor() as i32 as u32)
}

fn cell_number([x, y, z]: [u32; 3], flat: bool) -> f32 {
    hash::unit(if flat {
        hash::words_2(x, y)
    } else {
        hash::words_3(x, y, z)
    })
}

fn cell_numbers([x, y, z]: [u32; 3], flat: bool) -> Vec3 {
    Vec3::from([0, 1, 2].map(|channel| {
        hash::unit(if flat {
            hash::words_3(x, y, channel)
        } else {
            hash::words_4(x, y, z, channel)
        })
    }))
}

/// Distances to the three nearest points, and where the nearest is.
fn nearest_points(place: Vec3, jitter: f32, flat: bool) -> (Vec3, Vec3) {
    // Further away than any point: distances of what is no number.
    const FAR: f32 = 1e6;
    let middle = Vec3::splat(0.5);
    let here = cell_of(place);
    let within = place - place.floor();
    let mut squares = [FAR; 3];
    let mut nearest = Vec3::ZERO;
    let depth = if flat { 0..=0 } else { -1..=1 };
    for x in -1..=1 {
        for y in -1..=1 {
            for z in depth.clone() {
                let steps = [x, y, z];
                let cell = [0, 1, 2].map(|i| here[i].wrapping_add_signed(steps[i]));
                let point = (cell_numbers(cell, flat) - middle) * jitter + middle;
                let mut way = point + Vec3::from(steps.map(|s| s as f32)) - within;
                if flat {
                    way.z = 0.0;
                }
                let square = way.length_squared();
                let Some(rank) = squares.iter().position(|other| square < *other) else {
                    continue;
                };
                squares[rank..].rotate_right(1);
                squares[rank] = square;
                if rank == 0 {
                    nearest = way;
                }
            }
        }
    }
    (Vec3::from(squares.map(f32::sqrt)), nearest + place)
}

#[cfg(test)]
#[path = "../../tests/unit/nodes/materialx.rs"]
mod tests;
