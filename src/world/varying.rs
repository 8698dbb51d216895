//! What fills a mesh or all space and varies: its node tree at points of it, and bounds for the way through it.

use super::asking::{Asking, Past};
use super::material::Preparer;
use super::view::{View, from_blender, to_blender};
use crate::math::float::Affine;
use crate::medium::particles::{Draine, FournierForand, droplets};
use crate::medium::tracking::{Bound, Local, Majorants, even, widening};
use crate::medium::{Lobe, Phase};
use crate::scene::graph::function::{PlaceInput, Space, Transformed};
use crate::scene::graph::{Graph, NormalSpace};
use crate::scene::{self, Grid, Instance, Mesh, ObjectInfo, RayKind, Scene, TextureSpace};
use crate::shading::program::{Met, Openness, Place, VolumeProgram};
use glam::{DAffine3, DMat3, DVec3, Mat3, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A medium that varies.
#[derive(Debug)]
pub(super) struct Varying {
    program: VolumeProgram,
    facts: Facts,
    /// Bounds of its extinction.
    pub majorants: Majorants,
}

/// What a tree may ask about what it fills.
#[derive(Clone, Debug)]
struct Facts {
    /// The world's origin.
    origin: Vec3,
    view: View,
    /// Of an object.
    object: Option<ObjectAxes>,
    /// Of what fills it, by their numbers.
    grids: Vec<Option<PlacedGrid>>,
    /// What volume shaders say is multiplied with this.
    density: f32,
}

#[derive(Clone, Debug)]
struct PlacedGrid {
    grid: Arc<Grid>,
    /// From places relative to the origin to the numbers of its points.
    index_from_world: Affine,
}

impl PlacedGrid {
    fn index(&self, point: Vec3) -> Vec3 {
        self.index_from_world.vector(point) + self.index_from_world.translation
    }

    /// Around a box: its corner and the opposite one among the grid's points.
    fn bounds(&self, (low, high): (Vec3, Vec3)) -> (Vec3, Vec3) {
        let corners = (0..8).map(|i| {
            let side = |bit: i32| ((i >> bit) & 1) as f32;
            self.index(low + (high - low) * Vec3::new(side(0), side(1), side(2)))
        });
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        corners.fold(start, |(a, b), p| (a.min(p), b.max(p)))
    }
}

#[derive(Clone, Debug)]
struct ObjectAxes {
    /// From places relative to the origin to the object's space.
    object_from_world: Affine,
    /// Its axes in the world, and the other way round.
    axes: (Mat3, Mat3),
    /// Where its origin is, in Blender's axes.
    location: Vec3,
    info: ObjectInfo,
    texture_space: TextureSpace,
}

/// Cells along each axis, where there are few volumes and where there are many: their bounds take 128 KiB or less each.
const CELLS: [(usize, u32); 3] = [(8, 32), (64, 16), (usize::MAX, 8)];

/// So far from the origin reaches what fills all space, metres: as in Cycles.
const REACH: f32 = 10_000.0;

/// Cells along each axis of one of so many volumes.
pub(super) fn cells(volumes: usize) -> u32 {
    let (_, count) = CELLS[CELLS.iter().position(|c| volumes <= c.0).unwrap_or(2)];
    count
}

impl Varying {
    /// Of an object.
    pub fn of_object(
        scene: &Scene,
        (instance, mesh): (&Instance, &Mesh),
        graph: &Graph,
        (origin, view): (DVec3, View),
        cells: u32,
    ) -> Self {
        let place = &instance.world_from_object;
        let placed = DAffine3 {
            translation: place.translation - origin,
            ..*place
        };
        let inverse = |m: DMat3| {
            if m.determinant() == 0.0 {
                m
            } else {
                m.inverse()
            }
        };
        let back = DAffine3 {
            matrix3: inverse(placed.matrix3),
            translation: -(inverse(placed.matrix3) * placed.translation),
        };
        let facts = Facts {
            origin: origin.as_vec3(),
            view,
            object: Some(ObjectAxes {
                object_from_world: Affine::from_f64(&back, DVec3::ZERO),
                axes: (placed.matrix3.as_mat3(), back.matrix3.as_mat3()),
                location: to_blender(place.translation.as_vec3()),
                info: instance.info.clone(),
                texture_space: mesh.texture_space,
            }),
            grids: placed_grids(mesh, &back),
            density: density(mesh, place),
        };
        // Where it goes while the shutter is open, too.
        let poses = std::iter::once(place).chain(&instance.motion);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for pose in poses {
            let shapes = std::iter::once(&mesh.positions);
            for p in shapes
                .chain(mesh.motion.iter().map(|step| &step.positions))
                .flatten()
            {
                let p = (pose.transform_point3(Vec3::from(*p).as_dvec3()) - origin).as_vec3();
                (low, high) = (low.min(p), high.max(p));
            }
        }
        let cells = cells.max(cells_of(mesh).min(2 * cells));
        Self::new(scene, graph, facts, even(low, high, cells))
    }

    /// Of all space, as far as Cycles goes: bounded more narrowly in a box.
    pub fn of_space(
        scene: &Scene,
        graph: &Graph,
        (origin, view): (DVec3, View),
        (low, high): (Vec3, Vec3),
    ) -> Self {
        let facts = Facts {
            origin: origin.as_vec3(),
            view,
            object: None,
            grids: Vec::new(),
            density: 1.0,
        };
        let planes = widening(low, high, CELLS[1].1, REACH);
        Self::new(scene, graph, facts, planes)
    }

    fn new(scene: &Scene, graph: &Graph, facts: Facts, planes: [Box<[f32]>; 3]) -> Self {
        let program = Preparer::default().volume(scene, graph);
        let pasts = pasts(&program);
        let askers = askers(&program, &pasts);
        let local = |point: Vec3| of_any(&program, &facts, (point, &[]), &askers);
        let range = |low: Vec3, high: Vec3| range(&program, &facts, (low, high), &askers);
        let majorants = Majorants::new(planes, local, range);
        Self {
            program,
            facts,
            majorants,
        }
    }

    /// What a ray finds at a point, relative to the origin; the lobes are added to those that are asked for.
    pub fn local(&self, point: Vec3, asking: &Asking, lobes: Option<&mut Vec<Lobe>>) -> Local {
        local(&self.program, &self.facts, (point, &[]), asking, lobes)
    }

    /// Whether any of its shaders scatters light.
    pub fn scatters(&self) -> bool {
        self.program.scatters()
    }

    /// Whether it is another for another camera.
    pub fn asks_about_view(&self) -> bool {
        self.program.asks_about().view
    }
}

fn placed_grids(mesh: &Mesh, object_from_world: &DAffine3) -> Vec<Option<PlacedGrid>> {
    let grids = mesh.grids.iter().flat_map(|grids| &grids.by_number);
    let placed = grids.map(|grid| {
        let grid = grid.as_ref()?;
        // Numbers of points go by Blender's axes, as meshes' own do.
        let index_from_world = grid.object_from_index.inverse() * *object_from_world;
        Some(PlacedGrid {
            grid: grid.clone(),
            index_from_world: Affine::from_f64(&index_from_world, DVec3::ZERO),
        })
    });
    placed.collect()
}

/// As in Cycles: of volumes whose densities hold in the object's space, by how long its diagonal becomes.
fn density(mesh: &Mesh, world_from_object: &DAffine3) -> f32 {
    let by_object = mesh
        .grids
        .as_ref()
        .is_some_and(|grids| grids.density_by_object);
    let length = (world_from_object.matrix3 * DVec3::ONE.normalize()).length();
    if by_object && length > 0.0 {
        (1.0 / length) as f32
    } else {
        1.0
    }
}

/// Points of a grid along a cell, about.
const POINTS_OF_CELL: i32 = 4;

/// Cells along each axis that a mesh's grids ask for.
fn cells_of(mesh: &Mesh) -> u32 {
    let grids = mesh.grids.iter().flat_map(|grids| grids.all());
    let extents = grids.filter_map(|grid| {
        let (low, high) = grid.active?;
        Some(high.saturating_sub(low).max_element() / POINTS_OF_CELL)
    });
    extents.max().unwrap_or(0).max(0) as u32
}

/// Of grids' numbers, each one's least and greatest: what the program says of all of the ones, and of all of the others. Most
/// shaders rise or fall with each of them.
fn range(
    program: &VolumeProgram,
    facts: &Facts,
    (low, high): (Vec3, Vec3),
    askers: &[Asking],
) -> Option<Bound> {
    if program.grids().is_empty() {
        return None;
    }
    let middle = 0.5 * (low + high);
    let (mut least, mut most) = (Vec::new(), Vec::new());
    for &(number, how) in program.grids() {
        if let Some(placed) = facts.grids.get(number as usize).and_then(Option::as_ref) {
            let (from, to) = placed.bounds((low, high));
            let (mut a, mut b) = placed.grid.range(from, to, how);
            if placed.grid.channels() != 4 {
                (a.w, b.w) = (1.0, 1.0);
            }
            least.push((number, a));
            most.push((number, b));
        }
    }
    let mut bound = Bound {
        by_range: program.is_of_grids_alone(),
        settled: program.is_of_grids_alone() && least == most,
        ..Bound::default()
    };
    for given in [&least, &most] {
        let found = of_any(program, facts, (middle, given), askers);
        let extinction = found.extinction.max_element();
        if extinction.is_finite() {
            bound.extinction = bound.extinction.max(extinction);
        }
        bound.emits |= found.is_asked_for();
        if bound.settled {
            break;
        }
    }
    Some(bound)
}

/// What scatters, prepared: droplets are two kinds of lobes.
pub(super) fn lobes(coefficient: Vec3, of: scene::Phase) -> impl Iterator<Item = Lobe> {
    let (phase, other) = match of {
        scene::Phase::HenyeyGreenstein(g) => (Phase::HenyeyGreenstein(g), None),
        scene::Phase::Rayleigh => (Phase::Rayleigh, None),
        scene::Phase::Draine { anisotropy, alpha } => {
            let g = anisotropy;
            (Phase::Draine(Draine { g, alpha }), None)
        }
        scene::Phase::FournierForand { ior, backscatter } => {
            let floating = FournierForand::new(ior, backscatter);
            (Phase::FournierForand(floating), None)
        }
        scene::Phase::Mie(diameter) => {
            let (g, draine, share) = droplets(diameter);
            let other = (Phase::Draine(draine), share);
            (Phase::HenyeyGreenstein(g), Some(other))
        }
    };
    let rest = 1.0 - other.map_or(0.0, |(_, share)| share);
    let both = std::iter::once((phase, rest)).chain(other);
    let lobes = both.map(move |(phase, share)| Lobe {
        coefficient: coefficient * share,
        phase,
    });
    lobes.filter(|lobe| lobe.coefficient != Vec3::ZERO)
}

/// Paths that find its bounds: one where all find the same, else some that were scattered so often. What others find may be above the
/// bound; that is noise, no error (`medium::tracking`).
fn pasts(program: &VolumeProgram) -> Vec<Past> {
    let depths: &[u8] = match program.asks_about() {
        asks if asks.depths => &[0, 1, 2, 4, 8, 16],
        asks if asks.kinds => &[0, 1],
        _ => &[0],
    };
    let past = |&depth: &u8| Past {
        depths: [depth; 5],
        singular: depth > 0,
        reflected: depth > 0,
        ..Past::UNKNOWN
    };
    depths.iter().map(past).collect()
}

/// Rays of such paths: one where all rays find the same, else of each kind and in some directions.
fn askers<'p>(program: &VolumeProgram, pasts: &'p [Past]) -> Vec<Asking<'p>> {
    let asks = program.asks_about();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut ways = axes.into_iter().flat_map(|way| [way, -way]).cycle();
    let kinds = RayKind::ALL.map(|(kind, _)| kind.bit());
    let kinds: &[u32] = if asks.kinds { &kinds } else { &[0] };
    let of_past = |past: &'p Past| kinds.iter().map(move |&kind| (kind, past));
    let each: Vec<_> = pasts.iter().flat_map(of_past).collect();
    let least = if asks.directions { 6 } else { 1 };
    let count = each.len().max(least);
    let of_each = each.iter().cycle().zip(&mut ways).take(count);
    of_each
        .map(|(&(kind, past), way)| Asking {
            kind,
            depth: u32::from(past.depths[0]),
            past,
            ..Asking::along(way)
        })
        .collect()
}

/// The most that any of these rays finds.
fn of_any(
    program: &VolumeProgram,
    facts: &Facts,
    at: (Vec3, &[(u32, Vec4)]),
    askers: &[Asking],
) -> Local {
    let found = askers
        .iter()
        .map(|asking| local(program, facts, at, asking, None));
    found
        .reduce(|a, b| Local {
            extinction: a.extinction.max(b.extinction),
            scattering: a.scattering.max(b.scattering),
            emission: {
                // Of two the stronger; light that is taken away is nothing where nothing else is.
                let (least, most) = (a.emission.min(b.emission), a.emission.max(b.emission));
                if most.max_element() > 0.0 {
                    most
                } else {
                    least
                }
            },
        })
        .unwrap_or_default()
}

fn local(
    program: &VolumeProgram,
    facts: &Facts,
    (point, given): (Vec3, &[(u32, Vec4)]),
    asking: &Asking,
    mut asked: Option<&mut Vec<Lobe>>,
) -> Local {
    let mut scattering = Vec3::ZERO;
    let place = VolumePlace {
        facts,
        point,
        given,
        asking,
    };
    let (absorption, emission) = program.at(&place, facts.density, |coefficient, how| {
        scattering += coefficient;
        if let Some(asked) = &mut asked {
            asked.extend(lobes(coefficient, how));
        }
    });
    Local {
        extinction: absorption + scattering,
        scattering,
        emission,
    }
}

/// A point of a volume, as Cycles tells it to its nodes.
struct VolumePlace<'a> {
    facts: &'a Facts,
    /// Relative to the origin.
    point: Vec3,
    /// What these grids are said to have there.
    given: &'a [(u32, Vec4)],
    asking: &'a Asking<'a>,
}

impl VolumePlace<'_> {
    /// In the object's space, Blender's axes; of all space the world's.
    fn in_object(&self) -> Vec3 {
        match &self.facts.object {
            Some(object) => {
                let m = &object.object_from_world;
                m.vector(self.point) + m.translation
            }
            None => self.in_world(),
        }
    }

    /// In the world, Blender's axes.
    fn in_world(&self) -> Vec3 {
        to_blender(self.point + self.facts.origin)
    }

    /// In the camera's space.
    fn in_camera(&self) -> Vec3 {
        let m = &self.facts.view.camera;
        m.vector(self.point) + m.translation
    }

    /// The same for coordinates: those of all space Cycles takes as directions from the camera.
    fn camera_coordinates(&self) -> Vec3 {
        if self.facts.object.is_some() {
            return self.in_camera();
        }
        let m = &self.facts.view.camera;
        m.vector(self.point + self.facts.origin)
    }

    /// Where it is in the picture.
    fn in_window(&self) -> Vec3 {
        let view = &self.facts.view;
        view.window(if view.is_orthographic() {
            self.in_camera()
        } else {
            self.camera_coordinates()
        })
    }

    /// To where the ray comes from, Blender's axes: there, normals are this.
    fn incoming(&self) -> Vec3 {
        -to_blender(self.asking.direction).normalize_or_zero()
    }
}

impl Place for VolumePlace<'_> {
    /// Zero with v upwards, where images without coordinates are seen: there are none, as in Cycles.
    fn uv(&self, _: u32) -> Vec2 {
        Vec2::Y
    }

    fn color(&self) -> Vec4 {
        Vec4::ZERO
    }

    fn mapped_normal(&self, _: NormalSpace, _: Vec3, _: f32) -> Vec3 {
        Vec3::ZERO
    }

    fn input(&self, input: PlaceInput) -> Vec4 {
        let full = |v: Vec3| v.extend(1.0);
        let number = Vec4::splat;
        let object = self.facts.object.as_ref();
        match input {
            PlaceInput::Generated => {
                let p = self.in_object();
                full(object.map_or(p, |object| object.texture_space.generated(p)))
            }
            PlaceInput::Object => full(self.in_object()),
            PlaceInput::Position => full(self.in_world()),
            PlaceInput::OfObject(rows) => {
                let p = self.in_world().extend(1.0);
                full(Vec3::from(rows.map(|row| Vec4::from(row).dot(p))))
            }
            PlaceInput::ObjectLocation => full(object.map_or(Vec3::ZERO, |o| o.location)),
            PlaceInput::ObjectColor => object.map_or(Vec4::ZERO, |o| Vec4::from(o.info.color)),
            PlaceInput::ObjectAlpha => number(object.map_or(0.0, |o| o.info.color[3])),
            PlaceInput::ObjectIndex => number(object.map_or(0.0, |o| o.info.index)),
            PlaceInput::ObjectRandom => number(object.map_or(0.0, |o| o.info.random)),
            PlaceInput::MaterialIndex(index) => number(index),
            PlaceInput::ObjectValue(n) => {
                let value = object.and_then(|o| o.info.values.get(n as usize));
                value.map_or(Vec4::ZERO, |value| Vec4::from(*value))
            }
            PlaceInput::Grid {
                number: of,
                interpolation,
                otherwise,
            } => {
                let Some(placed) = self.facts.grids.get(of as usize).and_then(Option::as_ref)
                else {
                    return number(otherwise);
                };
                let given = self.given.iter().find(|given| given.0 == of);
                let value = given.map_or_else(
                    || placed.grid.sample(placed.index(self.point), interpolation),
                    |given| given.1,
                );
                match value.w {
                    // Colours are interpolated with their alpha in them.
                    w if w > 1e-6 && w != 1.0 => (value.truncate() / w).extend(w),
                    _ => value,
                }
            }
            PlaceInput::Incoming
            | PlaceInput::Normal
            | PlaceInput::TrueNormal
            | PlaceInput::Reflection => full(self.incoming()),
            PlaceInput::ObjectNormal => full(self.transformed(
                self.incoming(),
                Transformed::Normal,
                Space::World,
                Space::Object,
            )),
            // Of the first corner of no triangle.
            PlaceInput::Parametric => full(Vec3::X),
            PlaceInput::Camera => full(self.camera_coordinates()),
            PlaceInput::Window => full(self.in_window()),
            PlaceInput::ViewVector => full(self.in_camera().normalize_or_zero()),
            PlaceInput::ViewDepth => number(self.in_camera().z),
            PlaceInput::ViewDistance => number(self.in_camera().length()),
            PlaceInput::IsRay(kinds) => number(f32::from(self.asking.kind & kinds != 0)),
            PlaceInput::RayDepth => number(self.asking.depth as f32),
            PlaceInput::IsSingularRay => number(f32::from(self.asking.past.singular)),
            PlaceInput::IsReflectionRay => number(f32::from(self.asking.past.reflected)),
            PlaceInput::PathDepth(depth) => number(self.asking.past.depth(depth)),
            // What only surfaces have. Rays have no length here, as in Cycles.
            _ => Vec4::ZERO,
        }
    }

    fn transformed(&self, v: Vec3, what: Transformed, from: Space, to: Space) -> Vec3 {
        if from == to {
            return v;
        }
        let facts = self.facts;
        let origin = (what == Transformed::Point).then_some(facts.origin);
        let object = facts.object.as_ref();
        let world = match (from, object) {
            (Space::Camera, _) => facts.view.world_from_camera(v, origin),
            (Space::Object, Some(object)) => match what {
                Transformed::Point => object.axes.0 * v + from_blender(object.location),
                Transformed::Vector => object.axes.0 * v,
                Transformed::Normal => object.axes.1.transpose() * v,
            },
            _ => from_blender(v),
        };
        let result = match (to, object) {
            (Space::Camera, _) => facts.view.camera_from_world(world, origin),
            (Space::Object, Some(object)) => match what {
                Transformed::Point => object.axes.1 * (world - from_blender(object.location)),
                Transformed::Vector => object.axes.1 * world,
                Transformed::Normal => object.axes.0.transpose() * world,
            },
            _ => to_blender(world),
        };
        match what {
            Transformed::Normal => result.normalize_or_zero(),
            _ => result,
        }
    }

    // There is no surface. Its own normal is the way that light comes from, as in Cycles.
    fn facing(&self, outside: Vec3) -> Vec3 {
        if outside == Vec3::ZERO {
            self.incoming()
        } else {
            to_blender(outside)
        }
    }

    fn outside(&self, facing: Vec3) -> Vec3 {
        from_blender(facing).normalize_or_zero()
    }

    fn steps(&self, _: f32) -> [Vec3; 2] {
        [Vec3::ZERO; 2]
    }

    fn of_neighbours(&self, _: [Vec3; 2], mut number: impl FnMut(&Self) -> f32) -> [f32; 2] {
        [number(self); 2]
    }

    fn undisplaced(&self, _: u32, _: bool) -> Self {
        Self { ..*self }
    }

    fn openness(&self, _: Vec3, _: f32, _: Openness) -> f32 {
        1.0
    }

    fn beveled(&self, _: f32, _: u8) -> Vec3 {
        Vec3::ZERO
    }

    fn met(&self, _: (Vec3, Vec3, f32), _: bool) -> Option<Met> {
        None
    }

    fn is_on_edge(&self, _: f32, _: bool) -> bool {
        false
    }
}
