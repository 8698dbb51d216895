//! Light from all around: a constant, an equirectangular image, or what a node tree computes, each sampled in two dimensions.
//!
//! Blender's mapping: with Blender's axes (x, y, z up) the image's column is
//! u = ½ − atan2(y, x)/2π and its row from the bottom v = ½ + asin(z)/π; the Mapping node turns
//! the direction first. Sundog's axes are glTF's: x = x, y = z(up), z = −y.

use super::area::Area;
use super::kinds::LightSampleContext;
use super::portal::Portals;
use super::program::{LightProgram, LookingRay, ShinePoint};
use super::texels::Texels;
use super::{Direction, LightHit};
use crate::math::float::ONE_MINUS_EPSILON;
use crate::math::{average, floor, luminance, warp};
use crate::scene::RayKind;
use glam::{DMat3, DVec3, Mat3, Vec2, Vec3};
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// An environment.
#[derive(Debug)]
pub struct Environment {
    radiance: Vec3,
    /// Orthonormal, by glTF's axes.
    image_from_world: Mat3,
    kind: Kind,
    /// Openings through which it is looked for as well, if there are any.
    portals: Option<Box<Portals>>,
    /// How strongly it shines, guessed as Cycles does.
    pub(super) guess: Vec3,
}

#[derive(Debug)]
enum Kind {
    Constant,
    Image(Box<Image>),
    Computed(Box<Computed>),
}

/// What a program computes. Light sampling finds it by a table.
#[derive(Debug)]
struct Computed {
    program: Box<dyn LightProgram>,
    distribution: Distribution,
    /// Over all directions.
    mean: Vec3,
    /// A bright disc that is sampled by itself, with a probability.
    disc: Option<(Disc, f32)>,
}

/// A small bright disc of the sky.
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    /// Toward its middle, unit length.
    pub toward: Vec3,
    /// 1 − cos of its angular radius.
    pub one_minus_cos: f32,
    /// The probability with which it is sampled by itself; by its light where there is none.
    pub share: Option<f32>,
    /// There is a sun, and not only what light sampling takes for one.
    pub shines: bool,
}

impl Disc {
    #[inline]
    fn contains(&self, d: Vec3) -> bool {
        0.5 * (d - self.toward).length_squared() <= self.one_minus_cos
    }
}

#[derive(Debug)]
struct Image {
    width: usize,
    height: usize,
    texels: Texels,
    distribution: Distribution,
}

/// Cells of the distribution along u at most: finer than that only costs memory.
const CELLS_U: usize = 2048;
/// Columns of a table of what a program computes.
const LEAST_COLUMNS: usize = 64;
const MOST_COLUMNS: usize = 4096;
/// A program is asked about so many directions at most, unless there are more texels.
const MOST_LOOKS: usize = 1 << 20;
/// Rows and columns of directions of a disc that a program is asked about.
const DISC_LOOKS: u32 = 8;
/// The share of the mean that every direction has in the table.
const FLOOR: f32 = 0.02;

/// By what light sampling finds what a program computes.
#[derive(Clone, Copy, Debug)]
pub struct SkyTable {
    /// Columns of cells.
    pub columns: usize,
    /// Cells weigh as in Cycles: by the mean of the channels in their middles, and what is dark there has no samples. Else no direction is
    /// without a chance.
    pub as_cycles: bool,
}

/// A piecewise constant density over cells of (u, row), by inversion of its sums.
#[derive(Debug)]
struct Distribution {
    columns: usize,
    rows: usize,
    /// For each row `columns + 1` sums, the last one 1.
    conditional: Vec<f32>,
    /// `rows + 1` sums, the last one 1.
    marginal: Vec<f64>,
    /// Where in them to look.
    conditional_guide: Guide,
    marginal_guide: Guide,
    /// Cosine of the polar angle (from up) at the upper edge of each row, and at the lower edge of the last.
    cosines: Vec<f64>,
    /// Density of each row for a share of 1 in one of its cells.
    densities: Vec<f64>,
}

/// Where rows of rising sums pass each of some equal steps from 0 to 1: a search has a few cells left to look at, and not
/// all the places of a bisection, most of which lie in memory that is not at hand. (Chen and Asau, *On Generating Random
/// Variates from an Empirical Distribution*, 1974: the method of cutpoints.)
#[derive(Debug)]
struct Guide {
    /// A power of 2, so that a number times it is exact.
    steps: usize,
    /// For each row `steps + 1` numbers of sums that are not above the step.
    passed: Vec<u16>,
}

/// Cells of a row for each step of its guide: what is left to search lies in a line or two of memory, and the guides of an image
/// of 1024 × 512, 128 kB, stay at hand where those with a step for each cell, 1 MB, did not.
const CELLS_A_STEP: usize = 8;

impl Guide {
    /// For rows of so many sums, the first 0 and the last 1; at most 65535.
    fn new<T: Copy + Into<f64>>(sums: &[T], length: usize) -> Self {
        let steps = ((length - 1) / CELLS_A_STEP).next_power_of_two();
        let mut passed = Vec::with_capacity(sums.len() / length * (steps + 1));
        for row in sums.chunks_exact(length) {
            let mut at = 0;
            for step in 0..=steps {
                let step = step as f64 / steps as f64;
                while at < length && row[at].into() <= step {
                    at += 1;
                }
                passed.push(at as u16);
            }
        }
        Self { steps, passed }
    }

    /// How many sums of a row are not above a number, 0 to below 1.
    #[inline]
    fn count<T: Copy + PartialOrd + From<f32>>(&self, row: usize, sums: &[T], u: f32) -> usize {
        let step = ((u * self.steps as f32) as usize).min(self.steps - 1);
        let passed = &self.passed[row * (self.steps + 1) + step..];
        let (from, to) = (usize::from(passed[0]), usize::from(passed[1]));
        from + sums[from..to].partition_point(|&sum| sum <= u.into())
    }
}

impl Environment {
    /// Whether all directions have the same radiance.
    pub fn is_constant(&self) -> bool {
        matches!(self.kind, Kind::Constant)
    }

    /// A constant.
    pub fn constant(radiance: Vec3) -> Self {
        Self {
            radiance,
            image_from_world: Mat3::IDENTITY,
            kind: Kind::Constant,
            portals: None,
            guess: radiance,
        }
    }

    /// An image: `texels` in rows from the top, linear; `radiance` multiplies it; `rotation` takes a direction
    /// of the world to that of the image, both by Blender's axes.
    pub fn image(
        width: usize,
        height: usize,
        texels: impl Into<Texels>,
        radiance: Vec3,
        rotation: &DMat3,
    ) -> Self {
        let texels = texels.into();
        let distribution = Distribution::new((width, height), &texels, radiance, false);
        // From glTF's axes to Blender's: (x, −z, y).
        let blender_from_gltf = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);
        let image_from_world = blender_from_gltf.transpose() * *rotation * blender_from_gltf;
        Self {
            radiance,
            image_from_world: image_from_world.as_mat3(),
            kind: Kind::Image(Box::new(Image {
                width,
                height,
                texels: texels.packed(),
                distribution,
            })),
            portals: None,
            guess: radiance,
        }
    }

    /// What a program computes, times the radiance. `disc`: where the program may show the sun.
    pub fn computed(
        program: Box<dyn LightProgram>,
        SkyTable { columns, as_cycles }: SkyTable,
        radiance: Vec3,
        disc: Option<Disc>,
    ) -> Self {
        let columns = columns.clamp(LEAST_COLUMNS, MOST_COLUMNS);
        let rows = columns / 2;
        // No kind of ray in particular, as in Cycles.
        let look = |d: Vec3| {
            let light = program.emitted(&ShinePoint::around(d, LookingRay::sampling(0)));
            // What is not a number is counted where paths find it.
            Vec3::select(light.is_finite_mask(), light.abs(), Vec3::ZERO)
        };
        let is_sun = |disc: &Disc| disc.shines;
        let beside = |d: Vec3| match disc.filter(|disc| is_sun(disc) && disc.contains(d)) {
            None => d,
            // The disc has its own samples: the table has what is beside it.
            Some(disc) => {
                let away = (d - disc.toward * d.dot(disc.toward)).try_normalize();
                let away = away.unwrap_or_else(|| disc.toward.any_orthonormal_vector());
                let sin = (disc.one_minus_cos * (2.0 - disc.one_minus_cos))
                    .max(0.0)
                    .sqrt();
                (disc.toward + away * (1.1 * sin)).normalize()
            }
        };
        let parts = (MOST_LOOKS / (columns * rows)).clamp(1, 4);
        let side = if parts >= 4 && !as_cycles { 2 } else { 1 };
        let texels: Vec<Vec3> = (0..columns * rows)
            .into_par_iter()
            .map(|i| {
                let (x, y) = (i % columns, i / columns);
                let at = |k: usize, part: usize| (k as f32) + (part as f32 + 0.5) / side as f32;
                let part = |k: usize| {
                    let u = at(x, k % side) / columns as f32;
                    let v = at(y, k / side) / rows as f32;
                    look(beside(Self::direction(u, (v * PI).cos())))
                };
                (0..side * side).map(part).sum::<Vec3>() / (side * side) as f32
            })
            .collect();
        let weights = (0..rows).map(|y| ((y as f32 + 0.5) / rows as f32 * PI).sin());
        let (sum, weight) = weights.zip(texels.chunks_exact(columns)).fold(
            (DVec3::ZERO, 0.0),
            |(sum, weight), (sin, row)| {
                let row: DVec3 = row.iter().map(|t| t.as_dvec3()).sum();
                let sin = f64::from(sin);
                (sum + row * sin, weight + sin * columns as f64)
            },
        );
        let mut mean = (sum / weight).as_vec3();
        // No bright spot between the places looked at is without a chance.
        let floor = if as_cycles { Vec3::ZERO } else { mean * FLOOR };
        let table: Vec<Vec3> = texels.into_iter().map(|t| t + floor).collect();
        let sought = disc.filter(|disc| !disc.shines);
        let sought = sought.and_then(|disc| Some((disc, disc.share?)));
        let disc = disc.filter(is_sun).and_then(|disc| {
            let middle = |i: u32| (i as f32 + 0.5) / DISC_LOOKS as f32;
            let looks = (0..DISC_LOOKS * DISC_LOOKS).map(|i| {
                let u = Vec2::new(middle(i % DISC_LOOKS), middle(i / DISC_LOOKS));
                look(warp::cone_about(disc.toward, u, disc.one_minus_cos))
            });
            let radiance = looks.sum::<Vec3>() / (DISC_LOOKS * DISC_LOOKS) as f32;
            // The share of all directions: (1 − cos) / 2.
            let of_mean = radiance * (0.5 * disc.one_minus_cos);
            let (light, all) = (luminance(of_mean), luminance(mean + of_mean));
            mean += of_mean;
            let share = disc.share.unwrap_or((light / all).clamp(0.1, 0.9));
            (light > 0.0).then_some((disc, share))
        });
        let disc = disc.or(sought);
        Self {
            radiance,
            image_from_world: Mat3::IDENTITY,
            kind: Kind::Computed(Box::new(Computed {
                distribution: Distribution::new(
                    (columns, rows),
                    &table.into(),
                    radiance,
                    as_cycles,
                ),
                program,
                mean,
                disc,
            })),
            portals: None,
            guess: radiance,
        }
    }

    /// With openings through which it shines into rooms.
    #[must_use]
    pub fn with_portals(self, portals: Vec<Area>) -> Self {
        Self {
            portals: Portals::new(portals).map(Box::new),
            ..self
        }
    }

    /// Whether it has such openings.
    pub fn has_portals(&self) -> bool {
        self.portals.is_some()
    }

    /// Mean radiance over all directions (for the choice between lights).
    pub fn mean(&self) -> Vec3 {
        let image = match &self.kind {
            Kind::Constant => return self.radiance,
            Kind::Computed(computed) => return computed.mean * self.radiance,
            Kind::Image(image) => image,
        };
        let mut sum = glam::DVec3::ZERO;
        let mut weight = 0f64;
        for y in 0..image.height {
            let sin = ((y as f64 + 0.5) / image.height as f64 * std::f64::consts::PI).sin();
            let row: DVec3 = (0..image.width)
                .map(|x| image.texels.at(y * image.width + x).as_dvec3())
                .sum();
            sum += row * sin;
            weight += sin * image.width as f64;
        }
        (sum / weight).as_vec3() * self.radiance
    }

    /// (u, row from the top), both 0..1, of a direction of the image.
    #[inline]
    fn coordinates(d: Vec3) -> Vec2 {
        let phi = (-d.z).atan2(d.x);
        // Once around at most, so that no division is needed to come back.
        let u = 0.5 - phi / TAU;
        let u = if u < 0.0 {
            u + 1.0
        } else if u >= 1.0 {
            u - 1.0
        } else {
            u
        };
        // atan2 keeps the poles accurate where asin would not.
        let v = 0.5 - d.y.atan2((d.x * d.x + d.z * d.z).sqrt()) / PI;
        Vec2::new(u, v)
    }

    /// Direction of the image of (u, cosine of the polar angle).
    #[inline]
    fn direction(u: f32, cos: f32) -> Vec3 {
        let phi = (0.5 - u) * TAU;
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Vec3::new(sin * phi.cos(), cos, -sin * phi.sin())
    }

    /// Radiance from a direction, as a ray sees it.
    #[inline]
    pub fn emitted(&self, d: Vec3, ray: LookingRay) -> Vec3 {
        match &self.kind {
            Kind::Constant => self.radiance,
            Kind::Image(image) => {
                self.radiance * image.bilinear(Self::coordinates(self.image_from_world * d))
            }
            Kind::Computed(computed) => self.radiance * computed.emitted(d, ray),
        }
    }

    /// What a ray finds. Its place in the image is looked up once, for the radiance and the density.
    #[inline]
    pub fn le(&self, d: Vec3, ray: LookingRay) -> LightHit {
        let (radiance, on) = match &self.kind {
            Kind::Constant => (self.radiance, Vec3::ZERO),
            Kind::Computed(computed) => (self.radiance * computed.emitted(d, ray), computed.on(d)),
            Kind::Image(image) => {
                let at = Self::coordinates(self.image_from_world * d);
                // The density beside the radiance, as both wait for memory. The camera asks for none.
                let density = if ray.kind == RayKind::Camera.bit() {
                    0.0
                } else {
                    image.distribution.pdf_at(at)
                };
                (self.radiance * image.bilinear(at), at.extend(density))
            }
        };
        LightHit {
            distance: f32::INFINITY,
            radiance,
            on,
        }
    }

    /// Draws a direction for a point, and the radiance from there.
    #[inline]
    pub fn sample_li(&self, at: &LightSampleContext, u: Vec2) -> Option<(Direction, Vec3)> {
        if let (Kind::Image(image), None) = (&self.kind, &self.portals) {
            let (u, cos, pdf) = image.distribution.sample(u);
            // What was drawn is a place of the image: it need not be found again by the direction.
            let radiance = self.radiance * image.bilinear(Vec2::new(u, cos.acos() / PI));
            let wi = self.image_from_world.transpose() * Self::direction(u, cos);
            return Some((Direction { wi, pdf }, radiance));
        }
        let direction = self.sample_from(at, u)?;
        let ray = LookingRay::sampling(at.bounces);
        Some((direction, self.emitted(direction.wi, ray)))
    }

    /// Draws a direction for a point: in proportion to the radiance, or toward an opening. `None` where an opening has no point to
    /// be seen.
    #[inline]
    pub fn sample_from(&self, at: &LightSampleContext, u: Vec2) -> Option<Direction> {
        match &self.portals {
            None => Some(self.sample(u)),
            Some(portals) => portals.sample(self, at, u),
        }
    }

    /// Density with which [`Self::sample_from`] finds what a ray has hit in a direction.
    #[inline]
    pub fn pdf_from(&self, at: &LightSampleContext, wi: Vec3, on: Vec3) -> f32 {
        let plain = self.pdf_li(on);
        match &self.portals {
            None => plain,
            Some(portals) => portals.pdf(at, wi, plain),
        }
    }

    /// Density with which [`Self::sample`] finds a direction.
    pub(super) fn plain_pdf(&self, d: Vec3) -> f32 {
        match &self.kind {
            Kind::Constant => self.pdf_li(Vec3::ZERO),
            Kind::Computed(computed) => computed.pdf(computed.on(d)),
            Kind::Image(image) => {
                let at = Self::coordinates(self.image_from_world * d);
                image.distribution.pdf_at(at)
            }
        }
    }

    /// Draws a direction in proportion to the radiance.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Direction {
        match &self.kind {
            Kind::Constant => Direction {
                wi: crate::math::warp::sphere(u),
                pdf: 1.0 / (4.0 * PI),
            },
            Kind::Computed(computed) => computed.sample(u),
            Kind::Image(image) => {
                let (u, cos, pdf) = image.distribution.sample(u);
                Direction {
                    // The inverse of an orthonormal matrix.
                    wi: self.image_from_world.transpose() * Self::direction(u, cos),
                    pdf,
                }
            }
        }
    }

    /// Density with which [`Self::sample`] finds what a ray has hit.
    #[inline]
    pub fn pdf_li(&self, on: Vec3) -> f32 {
        match &self.kind {
            Kind::Constant => 1.0 / (4.0 * PI),
            Kind::Image(_) => on.z,
            Kind::Computed(computed) => computed.pdf(on),
        }
    }
}

impl Computed {
    #[cold]
    fn emitted(&self, d: Vec3, ray: LookingRay) -> Vec3 {
        self.program.emitted(&ShinePoint::around(d, ray))
    }

    /// Where in the table, and whether in the disc.
    fn on(&self, d: Vec3) -> Vec3 {
        let at = Environment::coordinates(d);
        let in_disc = self.disc.is_some_and(|(disc, _)| disc.contains(d));
        Vec3::new(at.x, d.y, f32::from(in_disc))
    }

    #[cold]
    fn sample(&self, u: Vec2) -> Direction {
        let mut x = u.x;
        if let Some((disc, share)) = &self.disc {
            if x < *share {
                let u = Vec2::new(x / share, u.y);
                let wi = warp::cone_about(disc.toward, u, disc.one_minus_cos);
                let at = Environment::coordinates(wi);
                // Rounding may place it beside the disc's edge.
                let pdf = self.pdf(Vec3::new(at.x, wi.y, 1.0));
                return Direction { wi, pdf };
            }
            x = ((x - share) / (1.0 - share)).min(ONE_MINUS_EPSILON);
        }
        let (u, cos, pdf) = self.distribution.sample(Vec2::new(x, u.y));
        let wi = Environment::direction(u, cos);
        let pdf = match &self.disc {
            None => pdf,
            Some(_) => self.pdf(self.on(wi)),
        };
        Direction { wi, pdf }
    }

    fn pdf(&self, on: Vec3) -> f32 {
        let table = self.distribution.pdf(on.x, on.y);
        let Some((disc, share)) = &self.disc else {
            return table;
        };
        let of_disc = if on.z > 0.0 {
            warp::cone_pdf(disc.one_minus_cos)
        } else {
            0.0
        };
        table * (1.0 - share) + of_disc * share
    }
}

impl Image {
    /// Bilinear between texel centres; wraps around in u, stops at the poles.
    #[inline]
    fn bilinear(&self, at: Vec2) -> Vec3 {
        let (x, y) = (
            at.x * self.width as f32 - 0.5,
            at.y * self.height as f32 - 0.5,
        );
        let ((x0, s), (y0, t)) = (floor(x), floor(y));
        let column = |x: i64| x.rem_euclid(self.width as i64) as usize;
        let row = |y: i64| (y.max(0) as usize).min(self.height - 1);
        let (c0, c1, r0, r1) = (column(x0), column(x0 + 1), row(y0), row(y0 + 1));
        let texel = |c: usize, r: usize| self.texels.at(r * self.width + c);
        texel(c0, r0)
            .lerp(texel(c1, r0), s)
            .lerp(texel(c0, r1).lerp(texel(c1, r1), s), t)
    }
}

impl Distribution {
    /// `as_cycles`: see [`SkyTable`].
    fn new(
        (width, height): (usize, usize),
        texels: &Texels,
        radiance: Vec3,
        as_cycles: bool,
    ) -> Self {
        let columns = width.min(CELLS_U);
        let rows = height.min(CELLS_U / 2);
        let brightness = if as_cycles { average } else { luminance };
        let weight =
            |x: usize, y: usize| f64::from(brightness((texels.at(y * width + x) * radiance).abs()));
        // Mean of the bilinear interpolation over each texel's cell: (1, 6, 1)/8 in both directions.
        // It is above 0 wherever the interpolation is somewhere above 0 in the cell.
        let smoothed_row = |y: usize| -> Vec<f64> {
            if as_cycles {
                return (0..width).map(|x| weight(x, y)).collect();
            }
            let (above, below) = (y.saturating_sub(1), (y + 1).min(height - 1));
            let vertical: Vec<f64> = (0..width)
                .map(|x| (weight(x, above) + 6.0 * weight(x, y) + weight(x, below)) / 8.0)
                .collect();
            (0..width)
                .map(|x| {
                    (vertical[(x + width - 1) % width]
                        + 6.0 * vertical[x]
                        + vertical[(x + 1) % width])
                        / 8.0
                })
                .collect()
        };
        let cosines: Vec<f64> = (0..=rows)
            .map(|r| (r as f64 / rows as f64 * std::f64::consts::PI).cos())
            .collect();
        let mut conditional = Vec::with_capacity(rows * (columns + 1));
        let mut marginal = vec![0f64];
        for r in 0..rows {
            let mut cells = vec![0f64; columns];
            // Texel rows and columns that touch the cell (every texel belongs to at least one cell).
            for y in r * height / rows..((r + 1) * height).div_ceil(rows).min(height) {
                for (x, w) in smoothed_row(y).into_iter().enumerate() {
                    let touched =
                        x * columns / width..((x + 1) * columns).div_ceil(width).min(columns);
                    cells[touched].iter_mut().for_each(|c| *c += w);
                }
            }
            let sum: f64 = cells.iter().sum();
            let mut running = 0f64;
            conditional.push(0.0);
            for (i, c) in cells.iter().enumerate() {
                running += if sum > 0.0 {
                    c / sum
                } else {
                    1.0 / columns as f64
                };
                conditional.push(if i + 1 == columns {
                    1.0
                } else {
                    running.min(1.0) as f32
                });
            }
            let last = marginal[marginal.len() - 1];
            marginal.push(last + sum * (cosines[r] - cosines[r + 1]));
        }
        let total = marginal[rows];
        if total > 0.0 {
            marginal.iter_mut().for_each(|m| *m /= total);
        } else {
            marginal
                .iter_mut()
                .enumerate()
                .for_each(|(r, m)| *m = 0.5 * (1.0 - cosines[r]));
        }
        marginal[rows] = 1.0;
        let densities = (0..rows).map(|r| {
            let solid_angle =
                (cosines[r] - cosines[r + 1]) * std::f64::consts::TAU / columns as f64;
            (marginal[r + 1] - marginal[r]) / solid_angle
        });
        Self {
            densities: densities.collect(),
            conditional_guide: Guide::new(&conditional, columns + 1),
            marginal_guide: Guide::new(&marginal, rows + 1),
            columns,
            rows,
            conditional,
            marginal,
            cosines,
        }
    }

    /// (u, cosine of the polar angle, density per solid angle).
    fn sample(&self, u: Vec2) -> (f32, f32, f32) {
        let v = f64::from(u.y);
        let r = self.marginal_guide.count(0, &self.marginal, u.y);
        let r = r.clamp(1, self.rows) - 1;
        let row = &self.conditional[r * (self.columns + 1)..][..=self.columns];
        let c = self.conditional_guide.count(r, row, u.x);
        let c = c.clamp(1, self.columns) - 1;
        let t = ((u.x - row[c]) / (row[c + 1] - row[c])).clamp(0.0, 1.0);
        let s =
            ((v - self.marginal[r]) / (self.marginal[r + 1] - self.marginal[r])).clamp(0.0, 1.0);
        let cos = self.cosines[r] + (self.cosines[r + 1] - self.cosines[r]) * s;
        (
            (c as f32 + t) / self.columns as f32,
            cos as f32,
            self.cell_pdf(c, r),
        )
    }

    fn pdf(&self, u: f32, cos: f32) -> f32 {
        let c = ((u * self.columns as f32) as usize).min(self.columns - 1);
        let r = (f64::from(cos.clamp(-1.0, 1.0)).acos() / std::f64::consts::PI * self.rows as f64)
            as usize;
        self.cell_pdf(c, r.min(self.rows - 1))
    }

    /// The same at a place of the image.
    #[inline]
    fn pdf_at(&self, at: Vec2) -> f32 {
        let c = ((at.x * self.columns as f32) as usize).min(self.columns - 1);
        let r = ((at.y * self.rows as f32) as usize).min(self.rows - 1);
        self.cell_pdf(c, r)
    }

    #[inline]
    fn cell_pdf(&self, c: usize, r: usize) -> f32 {
        let row = &self.conditional[r * (self.columns + 1)..][..=self.columns];
        (f64::from(row[c + 1] - row[c]) * self.densities[r]) as f32
    }
}

#[cfg(test)]
#[path = "../../tests/unit/light/environment.rs"]
mod tests;
