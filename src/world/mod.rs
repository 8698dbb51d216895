//! The prepared scene: recentred, in Embree, ready for rays. Read-only while rendering.

mod albedos;
mod asking;
mod camera;
mod covered;
mod crossings;
mod displacement;
mod draws;
mod fast_gi;
mod geometry;
mod insides;
mod interfaces;
mod lids;
mod lift;
mod lights;
mod linked;
mod material;
mod media;
mod moving;
mod neighbourhood;
mod nesting;
mod origin;
mod passing;
mod place;
mod placed;
mod portal;
mod shine;
mod strand;
mod surface;
mod turned;
mod varying;
mod view;

pub use crate::ffi::embree::{EmbreeError, Hit, InstructionSet};
pub use crate::light::Source;
pub use crate::scene::RayKind;
pub use asking::{Asking, Past, Sender, Widening};
pub use displacement::displace;
pub use draws::Draws;
pub use interfaces::Passage;
pub use media::{Flown, Met, Way, Within};
pub use nesting::OtherSide;
pub use place::HitPoint;
pub use strand::LeftStrand;
pub use surface::{Mixed, Surface, Wanted};

use crate::camera::{Camera, Shutter};
use crate::effects::{self, Effect, Features, General};
use crate::ffi::embree::{Device, Ray};
use crate::light::emissive::Eye;
use crate::light::{Drawn, LightSet};
use crate::math::float;
use crate::scene::{self, Scene};
use crate::shading::Normals;
use crate::shading::dispersion::Spectrum;
use crate::shading::program::{Computed, Place};
use asking::Around;
use enumset::EnumSet;
use geometry::MeshInstance;
use glam::{DVec3, Vec2, Vec3};
use material::PreparedMaterial;
use media::Media;
use moving::Moment;
use origin::{Extent, Origin};
use placed::Geometry;
use serde::Serialize;
use shine::Shine;
use std::sync::Arc;
use view::Views;

/// A scene ready for rays. Positions are relative to `origin`. Its parts are renewed each for itself ([`World::renew`]).
pub struct World {
    device: Device,
    geometry: Geometry,
    materials: Vec<Arc<PreparedMaterial>>,
    /// All that shines.
    pub lights: LightSet,
    /// The camera.
    pub camera: Camera,
    /// What the light from all around tells passes of the scene's own.
    aovs: Option<Shine>,
    /// For motion vectors, where somebody asks for any.
    views: Option<Views>,
    /// What fills meshes and space; `None` where nothing does.
    media: Option<Box<Media>>,
    /// When paths are on their way, and where the camera is then; `None` where nothing moves.
    pub shutter: Option<Shutter>,
    /// Where the paths begin, as the lights know it.
    eye: Eye,
    /// What was subtracted from all positions, world space, metres.
    pub origin: DVec3,
    /// Middle and radius of all there is.
    extent: Extent,
    /// The camera was far away from all of it when the origin was chosen.
    distant: bool,
    /// See [`Ablation::origin`].
    naive_origin: bool,
    cull_backfaces: bool,
    /// The wavelengths that paths are of, where some index of refraction depends on them.
    spectrum: Option<&'static Spectrum>,
    /// Paths take the kinds of scattering apart, as some kinds of rays see less than others.
    pub by_kind: bool,
    /// See [`Ablation::terminator`].
    naive_terminator: bool,
    /// The scene is from Blender: what Cycles has that is not consistent is as there ([`Self::ends_below`], [`Self::lights_backs`]).
    as_cycles: bool,
    /// The version of Embree that answers.
    pub embree_version: String,
    /// The instructions that it takes.
    pub instructions: InstructionSet,
}

/// Parts of a world that the scene has gone beyond. The view is always made anew: it costs nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stale {
    /// Meshes and their places.
    pub geometry: bool,
    /// Materials and images.
    pub materials: bool,
    /// Lights and the environment.
    pub lights: bool,
}

impl Stale {
    /// All parts.
    pub const ALL: Self = Self {
        geometry: true,
        materials: true,
        lights: true,
    };
    /// None but the view.
    pub const NONE: Self = Self {
        geometry: false,
        materials: false,
        lights: false,
    };
}

/// What keeps pictures stable and can be left out, to see what it is good for and what it costs. For studies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Ablation {
    /// Rays start a ten-thousandth of a metre off surfaces, whatever the scale, instead of by error bounds. The
    /// general kernel alone can do it.
    pub offsets: bool,
    /// Triangles are met by Embree's fast test, which rays can slip through at edges.
    pub edges: bool,
    /// Positions become f32 where they are, and not relative to the camera.
    pub origin: bool,
    /// Directions below a triangle are lost, although the curved surface that it stands for sees them.
    pub terminator: bool,
}

/// What a world is prepared for.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The camera.
    pub camera: &'a scene::Camera,
    /// Width over height of the picture.
    pub aspect: f64,
    /// Rows of the picture.
    pub rows: u32,
    /// Effects that are kept.
    pub effects: EnumSet<Effect>,
    /// Threads that build.
    pub threads: Option<usize>,
    /// Instructions that Embree is to take, if somebody asks for some.
    pub instructions: Option<InstructionSet>,
    /// Hide back faces of single-sided materials.
    pub cull_backfaces: bool,
    /// How light samples are shared out.
    pub light_shares: LightShares,
    /// Light of the first surface is clamped.
    pub clamps_direct: bool,
    /// What is left out.
    pub ablation: Ablation,
    /// Texture coordinates are shown by a pass.
    pub uv_pass: bool,
    /// Passes of the scene's own are shown.
    pub aovs: bool,
    /// Motion vectors are shown.
    pub vectors: bool,
    /// Paths make surfaces rougher than they are ("filter glossy").
    pub roughens: bool,
    /// What coincides in the scene; `None` if it has not been looked for.
    pub coincident: Option<&'a scene::coincident::Coincident>,
}

/// How light samples are shared out among lights. The picture is the same but for clamping, and for noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightShares {
    /// By what lights give to each place.
    #[default]
    ByPlace,
    /// By place, but clamped as if half of them went to surfaces and the others to all other lights alike: as in Cycles without its
    /// Light Tree.
    Even,
    /// By place, but clamped as if they were shared out as Cycles does with its Light Tree.
    AsTree,
}

/// What a ray with a limit of transparent surfaces met.
#[derive(Clone, Copy, Debug)]
pub enum Intersection {
    /// A surface that it does not pass, and how many it has passed.
    Surface(Hit, u32),
    /// Nothing.
    Nothing,
    /// One transparent surface too many, at this distance.
    Limit(f32),
}

impl World {
    /// Prepares a scene.
    ///
    /// # Errors
    /// If Embree fails.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self, EmbreeError> {
        let device = Device::new(options.threads, options.instructions)?;
        let Origin {
            at: origin,
            distant,
        } = if options.ablation.origin {
            Origin::NAIVE
        } else {
            Origin::new(scene, options.camera)
        };
        let materials = material::prepare(scene, options);
        let geometry = Geometry::new(scene, options, origin, &materials, &device)?;
        let eye = Eye::new(options.camera, origin);
        let lights = lights::prepare(
            scene,
            options.effects,
            (origin, eye, options.cull_backfaces),
            (
                options.view(origin),
                (options.light_shares, options.clamps_direct),
            ),
            &geometry,
            &materials,
            &device,
        )?;
        let view = (origin, distant);
        let mut made = Self {
            spectrum: spectrum(scene, &materials),
            aovs: aovs_around(scene, options, origin),
            views: views(scene, options, origin),
            geometry,
            materials,
            media: None,
            lights,
            camera: camera::prepare(options.camera, options.aspect, options.effects, view),
            shutter: camera::shutter(
                options.camera,
                &scene.shutter,
                options.aspect,
                options.effects,
                view,
            ),
            eye,
            origin,
            extent: origin::extent(scene),
            distant: distant.is_some(),
            naive_origin: options.ablation.origin,
            cull_backfaces: options.cull_backfaces,
            by_kind: options.effects.contains(Effect::RayVisibility)
                && effects::tells_rays_apart(scene),
            naive_terminator: options.ablation.terminator,
            as_cycles: scene.is_from_blender(),
            embree_version: device.version().to_string(),
            instructions: device.instructions(),
            device,
        };
        made.fill(scene, options.effects, options.view(origin));
        made.fill_camera(options.camera);
        Ok(made)
    }

    /// Makes anew what a changed scene calls for. The options are those of before, but for the camera and the aspect. Tells
    /// what was made anew beside the view: more than was `stale` where one part hangs on another, all where the camera has
    /// gone too far from the origin.
    ///
    /// # Errors
    /// If Embree fails; the world is then as it was.
    pub fn renew(
        &mut self,
        scene: &Scene,
        options: &Options,
        mut stale: Stale,
    ) -> Result<Stale, EmbreeError> {
        if stale.geometry {
            self.extent = origin::extent(scene);
        }
        if !self.keeps_origin(options.camera) {
            *self = Self::new(scene, options)?;
            return Ok(Stale::ALL);
        }
        let origin = self.origin;
        let made = stale.materials.then(|| material::prepare(scene, options));
        let materials = made.as_deref().unwrap_or(&self.materials);
        stale.geometry |= stale.materials && !self.geometry.fits(options, materials);
        let geometry = if stale.geometry {
            Some(Geometry::new(
                scene,
                options,
                origin,
                materials,
                &self.device,
            )?)
        } else {
            None
        };
        let eye = Eye::new(options.camera, origin);
        // What programs know of the view.
        stale.lights |= self.geometry.look(options.view(origin));
        stale.lights |= scene.environment.as_ref().is_some_and(|environment| {
            let world = environment.graph.as_ref();
            world.is_some_and(|world| shine::asks_about_view(&world.graph))
        });
        stale.lights |= scene.lights.iter().any(|light| {
            let graph = light.graph.as_ref();
            graph.is_some_and(|graph| shine::asks_about_view(graph))
        });
        // Which way closed lamps shine hangs on where the camera is.
        stale.lights |=
            stale.geometry || stale.materials || self.lights.depends_on(&self.eye, &eye);
        if stale.lights {
            let geometry = geometry.as_ref().unwrap_or(&self.geometry);
            self.lights = lights::prepare(
                scene,
                options.effects,
                (origin, eye, options.cull_backfaces),
                (
                    options.view(origin),
                    (options.light_shares, options.clamps_direct),
                ),
                geometry,
                materials,
                &self.device,
            )?;
            self.eye = eye;
        }
        self.aovs = aovs_around(scene, options, origin);
        self.views = views(scene, options, origin);
        self.by_kind =
            options.effects.contains(Effect::RayVisibility) && effects::tells_rays_apart(scene);
        if let Some(made) = made {
            self.spectrum = spectrum(scene, &made);
            self.materials = made;
        }
        if let Some(geometry) = geometry {
            self.geometry = geometry;
        }
        let view = (origin, None);
        let (aspect, effects) = (options.aspect, options.effects);
        self.camera = camera::prepare(options.camera, aspect, effects, view);
        self.shutter = camera::shutter(options.camera, &scene.shutter, aspect, effects, view);
        if stale.geometry || stale.materials || self.media_ask_about_view() {
            self.fill(scene, effects, options.view(origin));
        }
        self.fill_camera(options.camera);
        Ok(stale)
    }

    /// The wavelengths that paths are of, where some index of refraction depends on them.
    pub fn spectrum(&self) -> Option<&'static Spectrum> {
        self.spectrum
    }

    /// Whether the origin stays where it is for a camera.
    fn keeps_origin(&self, camera: &scene::Camera) -> bool {
        self.naive_origin
            || !(self.distant || origin::is_far(self.extent, camera))
                && origin::is_good(self.origin, camera)
    }

    /// Triangles, instances expanded.
    pub fn triangles(&self) -> u64 {
        self.geometry.triangles
    }

    /// Bytes of corners and of other attributes of vertices, each mesh once; Embree's own are not in it.
    pub fn mesh_bytes(&self) -> (u64, u64) {
        let bytes = self.geometry.meshes.iter().map(|mesh| mesh.bytes());
        bytes.fold((0, 0), |sum, mesh| (sum.0 + mesh.0, sum.1 + mesh.1))
    }

    /// Effects that kernels must have because of how this world is built.
    pub fn structure(&self) -> EnumSet<Effect> {
        let mut set = EnumSet::empty();
        if self.geometry.entries.iter().any(MeshInstance::is_instance) {
            set |= Effect::Instances;
        }
        if self.geometry.meshes.iter().any(|mesh| mesh.has_normals()) {
            set |= Effect::SmoothNormals;
        }
        if self.geometry.has_strands {
            set |= Effect::Strands;
        }
        set
    }

    /// Whether some material has other shaders than one Principled BSDF, or computes: only the general kernel has these.
    pub fn has_mixed_shaders(&self) -> bool {
        self.materials.iter().any(|m| m.is_mixed() || m.computes())
    }

    /// The material of an object (by its number among those with triangles): its number in the scene, or the
    /// number after the last for the default material.
    pub fn material_of(&self, object: u32) -> Option<u32> {
        let entry = self.geometry.entries.get(object as usize)?;
        Some(self.geometry.meshes.get(entry.mesh as usize)?.material)
    }

    /// How many times as steep light falls on a hit's object as it does.
    #[inline]
    pub fn steepness(&self, hit: &Hit) -> f32 {
        let steeper = &self.geometry.steeper;
        if steeper.is_empty() {
            return 1.0;
        }
        steeper[hit.object() as usize]
    }

    /// Whether a hit is on an object that makes a hole in the picture.
    #[inline]
    pub fn is_holdout(&self, hit: &Hit) -> bool {
        !self.geometry.holdouts.is_empty() && self.geometry.holdouts[hit.object() as usize]
    }

    /// Whether a hit is on a shadow catcher.
    #[inline]
    pub fn is_catcher(&self, hit: &Hit) -> bool {
        !self.geometry.catchers.is_empty() && self.geometry.catchers[hit.object() as usize]
    }

    /// First texture coordinates at a hit, v upwards as in Blender; 0 where the mesh has none.
    pub fn texture_coordinates(&self, hit: &Hit) -> Vec2 {
        let entry = &self.geometry.entries[hit.object() as usize];
        let mesh = &self.geometry.meshes[entry.mesh as usize];
        if !mesh.has_uvs() {
            return Vec2::ZERO;
        }
        let place = (hit.primitive, hit.u, hit.v);
        let uv = entry.at(mesh, place, Asking::along(Vec3::ZERO)).uv(0);
        Vec2::new(uv.x, 1.0 - uv.y)
    }

    /// Where a ray leaves a surface along `wi`; `beyond`: it goes through. `None` where the surface is in its way.
    #[inline]
    pub fn ray_origin<E: Features>(
        &self,
        hit: &Hit,
        surface: &Surface,
        wi: Vec3,
        beyond: bool,
    ) -> Option<Vec3> {
        if E::EVERYTHING && surface.is_strand {
            return Some(surface.point.point);
        }
        let normal = surface.normals.geometric;
        if wi.dot(normal) > 0.0 {
            return Some(float::ray_origin(surface.point, normal));
        }
        if beyond {
            return Some(float::ray_origin(surface.point, -normal));
        }
        if !E::CURVED {
            return None; // The surface is its triangles.
        }
        self.ray_origin_over_horizon(hit, surface)
    }

    /// Where a ray to a light starts: [`Self::ray_origin`], but in files from Blender as in Cycles, which starts those that graze
    /// the triangle on a curved surface. Nothing looks whether the way there is free.
    #[inline]
    pub fn light_ray_origin<E: Features>(
        &self,
        hit: &Hit,
        surface: &Surface,
        wi: Vec3,
        beyond: bool,
    ) -> Option<Vec3> {
        let curved = || {
            let normals = &surface.normals;
            let side = if beyond {
                -normals.geometric
            } else {
                normals.geometric
            };
            let grazing = grazing(wi.dot(side), wi.dot(normals.smooth).abs());
            (grazing > 0.0)
                .then(|| self.curved_origin(hit, surface, side, grazing))
                .flatten()
        };
        let is_asked = E::CURVED && self.as_cycles && !self.naive_terminator && !surface.is_strand;
        is_asked
            .then(curved)
            .flatten()
            .or_else(|| self.ray_origin::<E>(hit, surface, wi, beyond))
    }

    /// Such a place on the curved surface; `None` where it is flat.
    #[cold]
    #[inline(never)]
    fn curved_origin(
        &self,
        hit: &Hit,
        surface: &Surface,
        side: Vec3,
        grazing: f32,
    ) -> Option<Vec3> {
        let mut moment = None;
        let object = self.object_at::<General>(hit, &mut moment);
        let bulge = lift::bulge(object, hit, side) * grazing;
        // What is not above the error of the point is no height.
        let is_curved = bulge.dot(side) > side.abs().dot(surface.point.error);
        is_curved.then(|| float::ray_origin(surface.point, side) + bulge)
    }

    /// For directions below the triangle, but above the curved surface that it stands for: from that surface, if the way
    /// to it is free (Hanika, *Hacking the Shadow Terminator*, Ray Tracing Gems II, ch. 4; there the way is not traced,
    /// and light leaks where something else is nearer than the curved surface).
    #[cold]
    #[inline(never)]
    fn ray_origin_over_horizon(&self, hit: &Hit, surface: &Surface) -> Option<Vec3> {
        if self.naive_terminator {
            return None;
        }
        let mut moment = None;
        let object = self.object_at::<General>(hit, &mut moment);
        let normal = surface.normals.geometric;
        let lift = lift::lift(object, hit, normal);
        // What is not above the error of the point is no height.
        if lift.dot(normal) <= normal.abs().dot(surface.point.error) {
            return None;
        }
        let start = float::ray_origin(surface.point, normal);
        let ray = passing::shadow_ray((start, lift), 1.0, hit.time);
        (!self.geometry.embree.occluded(&ray)).then_some(start + lift)
    }

    /// Whether a path that is scattered along `wi` ends, as its direction is below the triangle. Cycles asks so where its
    /// BSDFs are sampled but not where lights are: what only the smooth normal sees has the light samples' part alone.
    #[inline]
    pub fn ends_below<E: Features>(&self, surface: &Surface, wi: Vec3, beyond: bool) -> bool {
        E::CURVED && self.as_cycles && !beyond && wi.dot(surface.normals.geometric) < 0.0
    }

    /// Whether light samples of a light meet the backs of glass' facets ([`crate::shading::Bsdf::evaluate_sampled`]). Cycles does
    /// not sample skies of one colour.
    #[inline]
    pub fn lights_backs(&self, drawn: Drawn) -> bool {
        self.as_cycles && !self.lights.is_even_sky(drawn)
    }

    /// Whether what Cycles has that is not consistent is as there. Beside the above: where some kinds of rays do not see a light, rays
    /// bring it by way of all lobes, whichever of them is their kind; a ray that goes through a surface is of two kinds.
    #[inline]
    pub fn is_as_in_cycles(&self) -> bool {
        self.as_cycles
    }

    /// For directions that the surface is in the way of, although its smooth normal sees them: the curved surface that it
    /// stands for is hollow there (or the way up to it is blocked), and what leaves it at such an angle meets it again
    /// close by, at the other end of a chord, under the same angle. That end is taken to be like this one: what is
    /// returned is how the ray arrives, turned with the surface to here. `kind`: of the ray.
    #[inline]
    pub fn self_intersection<E: Features>(
        &self,
        hit: &Hit,
        surface: &Surface,
        wi: Vec3,
        kind: RayKind,
    ) -> Option<Vec3> {
        if !E::CURVED {
            return None;
        }
        self.arrives_again(hit, surface, wi, kind)
    }

    #[cold]
    #[inline(never)]
    fn arrives_again(&self, hit: &Hit, surface: &Surface, wi: Vec3, kind: RayKind) -> Option<Vec3> {
        let Normals {
            geometric, curved, ..
        } = surface.normals;
        let cos = wi.dot(curved);
        let back = wi - curved * (2.0 * cos);
        let seen = self.geometry.entries[hit.object() as usize]
            .visibility
            .sees(kind);
        // From above the triangle, as the ray before it.
        let fits = cos > 0.0 && back.dot(geometric) < 0.0;
        (seen && fits && !self.naive_terminator).then_some(back)
    }

    /// The surface at a hit of the ray that begins at `origin`; `scratch` is for what it is made of.
    #[inline]
    pub fn surface<'a, E: Features>(
        &'a self,
        hit: &Hit,
        (origin, asking): (Vec3, Asking<'a>),
        wanted: Wanted,
        scratch: &'a mut Scratch,
    ) -> Surface<'a> {
        let Scratch { moment, computed } = scratch;
        let object = self.object_at::<E>(hit, moment);
        surface::surface::<E>(
            object,
            &self.materials[object.1.material as usize],
            hit,
            (origin, asking),
            wanted,
            self.traces().then_some(self),
            computed,
        )
    }
}

/// What a surface holds of its own, by whoever asks for it.
#[derive(Default)]
pub struct Scratch {
    /// The object at the time of the hit, where it moves.
    moment: Option<Box<Moment>>,
    /// What its program has computed, if its lobes are asked for later.
    computed: Option<Computed>,
}

/// The wavelengths that paths are of, where some index of refraction depends on them.
fn spectrum(scene: &Scene, materials: &[Arc<PreparedMaterial>]) -> Option<&'static Spectrum> {
    let disperses = materials.iter().any(|material| material.disperses());
    disperses.then(|| Spectrum::of(scene.color_management.working_space))
}

/// The pictures before and after, where they are asked for and the file has some.
fn views(scene: &Scene, options: &Options, origin: DVec3) -> Option<Views> {
    let size = (options.aspect, options.rows);
    let wanted = options.vectors && scene.shutter.still;
    wanted.then(|| Views::new(options.camera, size, origin, !scene.shutter.objects_alone))
}

/// What the light from all around tells passes of the scene's own, where those are shown.
fn aovs_around(scene: &Scene, options: &Options, origin: DVec3) -> Option<Shine> {
    let graph = scene.world_aovs.as_ref().filter(|_| options.aovs)?;
    let view = options.view(origin);
    Some(Shine::new(scene, graph, None, (origin, view)))
}

/// Cycles' Geometry Offset, as objects have it by default.
const GEOMETRY_OFFSET: f32 = 0.1;

/// How much of the way to the curved surface a ray to a light starts off its triangle, by its cosines to the triangle and to the
/// smooth normal: nothing where neither grazes.
#[inline]
fn grazing(triangle: f32, smooth: f32) -> f32 {
    let share = if smooth < GEOMETRY_OFFSET {
        2.0 - (triangle + smooth) / GEOMETRY_OFFSET
    } else {
        1.0 - triangle / GEOMETRY_OFFSET
    };
    share.clamp(0.0, 1.0)
}

impl Around for World {
    #[cold]
    fn meets(
        &self,
        (origin, direction, [near, far], time): (Vec3, Vec3, [f32; 2], f32),
        object: &MeshInstance,
    ) -> Option<(Hit, bool)> {
        let hit = self.geometry.embree.intersect(&Ray {
            origin: origin.to_array(),
            direction: direction.to_array(),
            near,
            far,
            mask: u32::MAX,
            time,
        })?;
        let met = &self.geometry.entries[hit.object() as usize];
        Some((hit, met.object == object.object))
    }

    #[cold]
    fn is_shut(&self, origin: Vec3, direction: Vec3, (far, time): (f32, f32)) -> bool {
        let ray = passing::shadow_ray((origin, direction), far, time);
        self.geometry.embree.occluded(&ray)
    }

    #[cold]
    fn normals(&self, hit: &Hit) -> (Vec3, Vec3) {
        let mut moment = None;
        let (entry, mesh, triangle) = self.object_at::<General>(hit, &mut moment);
        let outside = entry.geometric_normal::<General>(mesh, triangle);
        let place = (triangle, hit.u, hit.v);
        let at = entry.at(mesh, place, Asking::along(Vec3::ZERO));
        (outside, entry.smooth_normal(mesh, &at))
    }
}
