//! Materials with their textures and tables prepared.

use super::Options;
use super::albedos::AlbedoTables;
use super::asking::Past;
use super::covered::{self, layers_at};
use super::passing::{asks_paths, has_holdout, is_blended};
use crate::effects::{self, Effect};
use crate::math::primaries::WorkingSpace;
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::{Graph, ShaderRules, TangentKind};
use crate::scene::{ImageAlpha, ImageUse, Material, Scene, Texture};
use crate::shading::dielectrics::{Key, Needs};
use crate::shading::program::{
    Computed, Emission, Evaluation, Known, Place, Program, Programs, Shader, Shining, Source,
    VolumeProgram, Weighted, compile, parameters, reflected,
};
use crate::shading::simple::SimpleValues;
use crate::shading::tables::Estimate;
use crate::shading::texture::{PreparedTexture, Raster};
use crate::shading::thin_film::Film;
use crate::shading::{Bsdf, BsdfFeatures, Dielectrics, Principled, turned};
use glam::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

/// A material ready for rays.
#[derive(Debug)]
pub struct PreparedMaterial {
    pub(super) programs: Programs,
    /// What it is where nothing varies.
    base: Principled,
    /// Emitted radiance before textures.
    pub emission: Vec3,
    /// What it emits as one guesses it from its shaders alone.
    pub emission_estimate: Vec3,
    /// The scattering part is missing: only emission.
    pub unlit: bool,
    /// Light can pass beside it.
    pub translucent: bool,
    /// Paths stop there and decide for themselves what passes, as what passes straight on takes a colour.
    pub is_tinted: bool,
    /// It shines, and light can pass beside it: what a path passes shines into it by the share that it does not let pass.
    pub glows_in_passing: bool,
    /// All passes straight on everywhere.
    pub lets_all_pass: bool,
    /// It only bounds what fills it.
    pub only_bounds: bool,
    /// Somewhere it is glass.
    lets_through: bool,
    /// Somewhere it is solid glass.
    bounds_a_solid: bool,
    /// Back faces can be hidden.
    pub single_sided: bool,
    /// Tables of its dielectrics in air.
    tables: AlbedoTables,
    /// The same in other solids, by their indices of refraction, where priorities let it overlap with them.
    in_solids: Vec<(f32, AlbedoTables)>,
    /// Its index of refraction depends on the wavelength.
    disperses: bool,
    /// Light goes on below it.
    goes_below: bool,
    /// What goes on there has a normal of its own.
    bumps_below: bool,
    /// It sends rays elsewhere.
    has_portal: bool,
    /// The space of its colours.
    space: WorkingSpace,
}

/// Makes each raster once.
#[derive(Default)]
pub struct Preparer {
    /// By the image's number, and what opacity does to its texels.
    rasters: HashMap<(u32, ImageAlpha), Arc<Raster>>,
    /// Surfaces may be made rougher than their materials say.
    roughens: bool,
    /// What tables of solids hold, by the rules until 5.2, and what layers leave to their bases.
    estimate: Estimate,
}

/// So many tables are kept for the next world.
const KEPT: usize = 64;

/// Tables for a material. They take milliseconds to make and depend on nothing else, so that a program that renders one
/// scene after the other makes them once.
pub(super) fn tables_of(needs: Needs) -> Arc<Dielectrics> {
    let key = needs.key();
    static TABLES: Mutex<BTreeMap<Key, Arc<Dielectrics>>> = Mutex::new(BTreeMap::new());
    let locked = || TABLES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(tables) = locked().get(&key) {
        return tables.clone();
    }
    // Not while others wait.
    let tables = Arc::new(Dielectrics::needed(&needs));
    let mut kept = locked();
    if kept.len() >= KEPT {
        kept.clear();
    }
    kept.insert(key, tables.clone());
    tables
}

impl Preparer {
    /// `roughens`: surfaces may be made rougher than their materials say.
    pub fn new(roughens: bool, estimate: Estimate) -> Self {
        Self {
            roughens,
            estimate,
            ..Self::default()
        }
    }

    /// What tables of a solid hold. From 5.3 on those of Cycles are right.
    pub(super) fn estimate(&self, rules: ShaderRules) -> Estimate {
        match rules {
            ShaderRules::Before53 => self.estimate,
            ShaderRules::Since53 => Estimate::Exact,
        }
    }

    /// What layers of an index below 1 leave to their bases: those of Cycles leave too much, in all versions.
    pub(super) fn estimate_of_file(&self) -> Estimate {
        self.estimate
    }

    /// Whether surfaces may be made rougher than their materials say.
    pub(super) fn roughens(&self) -> bool {
        self.roughens
    }

    /// The programs of a graph that belongs to no surface.
    pub fn programs(&mut self, scene: &Scene, graph: &Graph) -> Programs {
        let known = Known {
            vertex_colors: false,
            space: scene.color_management.working_space,
        };
        let mut source = Textures {
            rasters: &mut self.rasters,
            scene,
        };
        compile(graph, known, &mut source)
    }

    /// Prepares what fills a mesh or all space.
    pub fn volume(&mut self, scene: &Scene, graph: &Graph) -> VolumeProgram {
        let known = Known {
            vertex_colors: false,
            space: scene.color_management.working_space,
        };
        let mut source = Textures {
            rasters: &mut self.rasters,
            scene,
        };
        VolumeProgram::new(graph, known, &mut source)
    }

    /// Prepares a material, for vertices with colours or without.
    pub fn material(
        &mut self,
        scene: &Scene,
        m: &Material,
        vertices: Vertices,
    ) -> PreparedMaterial {
        let known = Known {
            vertex_colors: vertices.colored,
            space: scene.color_management.working_space,
        };
        let mut source = Textures {
            rasters: &mut self.rasters,
            scene,
        };
        let programs = compile(&m.graph, known, &mut source);
        let summary = m.graph.summary(vertices.translucent);
        let p = summary.principled.first();
        let (base, linked) = match programs.shaders.first().map(|s| &s.shader) {
            Some(Shader::Principled { base, linked, .. }) => (*base, &linked[..]),
            _ => (MATTE, &[][..]),
        };
        let shaders = programs.shaders.iter().map(|weighted| &weighted.shader);
        let has_portal = shaders.clone().any(Shader::is_portal);
        let mut walks = shaders.filter(|shader| shader.goes_below());
        let mut solids = summary.principled.iter().filter(|p| p.transmits());
        let emission = programs.emission.constant().unwrap_or(summary.emission);
        let glows_in_passing = summary.is_translucent() && emission != Vec3::ZERO;
        PreparedMaterial {
            base,
            emission,
            emission_estimate: m.graph.emission_estimate(),
            glows_in_passing,
            unlit: summary.unlit,
            translucent: summary.is_translucent(),
            // Paths take note of where they enter a medium, and of what shines there.
            is_tinted: summary.is_translucent()
                && (summary.is_tinted
                    || glows_in_passing
                    || asks_paths(&programs)
                    || is_blended(&programs) && !summary.lets_all_pass
                    || has_portal
                    || has_holdout(&programs)
                    || m.medium.is_some()
                    || m.priority.is_some()),
            lets_all_pass: summary.lets_all_pass,
            only_bounds: summary.lets_all_pass && m.medium.is_some(),
            lets_through: solids.clone().next().is_some()
                || summary.is_thin_subsurface
                || summary.simple.iter().any(|(bsdf, _)| bsdf.transmits()),
            bounds_a_solid: solids.any(|p| !p.thin_wall)
                || summary.simple.iter().any(|(bsdf, _)| bsdf.bounds_a_solid()),
            single_sided: !m.double_sided,
            tables: self.albedo_tables((p, linked), &programs.shaders, 1.0),
            in_solids: self.in_solids(scene, m, (p, linked), &programs.shaders),
            disperses: summary.principled.iter().any(|p| p.spreads_colors()),
            goes_below: walks.clone().next().is_some(),
            // A displacement that is a bump gives all of them one. Cycles does not count one that is known: light comes out about the
            // smooth normal there, unless another shader has one that is not.
            bumps_below: programs.normal.is_some()
                || walks.any(|shader| {
                    let normal = shader.normal();
                    normal.is_some_and(|root| !programs.surface.is_known_vector(root))
                }),
            has_portal,
            space: known.space,
            programs,
        }
    }
}

/// A black surface, where there is no other.
const MATTE: Principled = Principled {
    base_color: Vec3::ZERO,
    metallic: 0.0,
    roughness: 1.0,
    ior: 1.5,
    dispersion: 0.0,
    specular: 0.0,
    specular_color: Vec3::ONE,
    edge_tint: false,
    rules: ShaderRules::Before53,
    once: false,
    pane: false,
    subsurface: 0.0,
    subsurface_anisotropy: 0.0,
    subsurface_color: Vec3::ZERO,
    below: None,
    subsurface_radius: Vec3::ZERO,
    subsurface_scale: 0.0,
    skin_ior: 1.4,
    film: Film::NONE,
    transmission: 0.0,
    thin_walled: true,
    diffuse_roughness: 0.0,
    anisotropy: 0.0,
    anisotropy_rotation: 0.0,
};

/// What the vertices of the meshes with a material have.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vertices {
    /// Colours.
    pub colored: bool,
    /// Some opacity below 1.
    pub translucent: bool,
}

/// The images of a scene.
pub(super) struct Textures<'a> {
    pub rasters: &'a mut HashMap<(u32, ImageAlpha), Arc<Raster>>,
    pub scene: &'a Scene,
}

impl Source for Textures<'_> {
    fn texture(&mut self, texture: &Texture, usage: ImageUse) -> Option<PreparedTexture> {
        let image = self.scene.images.get(texture.image.0 as usize)?;
        let alpha = texture.sampler.alpha.of_texels();
        let raster = self
            .rasters
            .entry((texture.image.0, alpha))
            .or_insert_with(|| Arc::new(Raster::new(image, alpha)));
        let space = self.scene.color_management.working_space;
        Some(PreparedTexture::new(texture, raster.clone(), usage, space))
    }
}

impl PreparedMaterial {
    /// Whether no ray gets through, nor beside it. By value, so that it is the same with the effects that are called for and
    /// with all: below metal there is no glass.
    pub fn is_opaque(&self) -> bool {
        !self.translucent && !self.lets_through
    }

    /// Whether its index of refraction depends on the wavelength.
    #[inline]
    pub fn disperses(&self) -> bool {
        self.disperses
    }

    /// Whether light goes on below it somewhere.
    pub fn goes_below(&self) -> bool {
        self.goes_below
    }

    /// Whether what goes on below it has a normal of its own.
    pub fn bumps_below(&self) -> bool {
        self.bumps_below
    }

    /// Whether it sends rays elsewhere.
    pub fn has_portal(&self) -> bool {
        self.has_portal
    }

    /// Whether rays are refracted by it into a solid somewhere.
    pub fn bounds_a_solid(&self) -> bool {
        self.bounds_a_solid
    }

    /// Whether it asks for tangents of texture coordinates, and for radial ones.
    pub fn tangents(&self) -> (bool, bool) {
        let reads = |kind| self.programs().any(|program| program.reads_tangent(kind));
        let maps = self.programs().any(Program::has_normal_map);
        (maps || reads(TangentKind::Uv), reads(TangentKind::Radial))
    }

    /// All of its programs.
    fn programs(&self) -> impl Iterator<Item = &Program> {
        let Programs {
            surface,
            opacity,
            emission,
            normal,
            aovs,
            ..
        } = &self.programs;
        let opacity = opacity.iter().map(|opacity| &opacity.program);
        let normal = normal.iter().map(|(program, _)| program);
        let aovs = aovs.iter().map(|aovs| &aovs.program);
        let both = [surface, &emission.program].into_iter();
        both.chain(opacity).chain(normal).chain(aovs)
    }

    /// What the material says at a point, and the normal of its map on the outside, 0 without one; `None` where it says the same
    /// everywhere ([`Self::constant_parameters`]).
    #[inline]
    pub fn parameters(
        &self,
        at: &impl Place,
        computed: &mut Option<Computed>,
    ) -> Option<(Principled, Vec3)> {
        if self.programs.surface.is_constant() {
            return None;
        }
        let shaders = &self.programs.shaders;
        let normal = |shader: &Shader, at: &mut Evaluation<'_, _>| {
            let root = shader.normal();
            root.map_or(Vec3::ZERO, |root| at.color(root))
        };
        let program = &self.programs.surface;
        Some(match &shaders.first()?.shader {
            shader @ Shader::Principled { base, linked, .. } if !self.is_mixed() => {
                let ask = |at: &mut Evaluation<'_, _>| {
                    let normal = normal(shader, at);
                    (parameters(base, linked, at), normal)
                };
                match computed {
                    Some(computed) => program.again(at, computed, ask),
                    None => program.at(at, ask),
                }
            }
            // Their lobes are asked for where they are added.
            _ => {
                let computed = computed.get_or_insert_default();
                let ask = |at: &mut Evaluation<'_, _>| {
                    // A shader of no weight here is not asked: its map may cost more than all else.
                    let there = shaders.iter().find(|of| at.number(&of.weight) > 0.0);
                    there.map_or(Vec3::ZERO, |there| normal(&there.shader, at))
                };
                (MATTE, program.again(at, computed, ask))
            }
        })
    }

    /// Whether it has other shaders than one Principled BSDF.
    #[inline]
    pub fn is_mixed(&self) -> bool {
        !self.tables.mixed.is_empty()
    }

    /// The tables of its dielectrics beside something of an index; 0: air.
    #[inline]
    pub fn tables_beside(&self, other_side: f32) -> &AlbedoTables {
        if other_side <= 0.0 {
            return &self.tables;
        }
        let distance = |(index, _): &&(f32, AlbedoTables)| (index - other_side).abs();
        let solids = self.in_solids.iter();
        let nearest = solids.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(&self.tables, |(_, tables)| tables)
    }

    /// Adds the lobes of its shaders for a path. `side` makes a shader's normal of that of its map, which is 0 where
    /// there is none; `computed` is what [`Self::parameters`] has computed there.
    pub fn add_shaders<K: BsdfFeatures>(
        &self,
        (place, past, computed): (&impl Place, &Past, &mut Computed),
        side: impl Fn(Vec3) -> Vec3,
        bsdf: &mut Bsdf<K>,
    ) {
        self.programs.surface.again(place, computed, |at| {
            let tables = &self.tables_beside(past.other_side).mixed;
            let shaders = self.programs.shaders.iter().zip(tables);
            for (Weighted { weight, shader }, tables) in shaders {
                let weight = at.number(weight);
                // What is not a number goes on, to be counted.
                if weight <= 0.0 {
                    continue;
                }
                let normal = shader.normal().map_or(Vec3::ZERO, |root| at.color(root));
                let normal = side(normal);
                let tangent = shader.tangent().map(|root| at.color(root));
                let tangent = tangent.filter(|tangent| *tangent != Vec3::ZERO);
                match shader {
                    Shader::Principled {
                        base,
                        linked,
                        layers,
                        ..
                    } => {
                        let p = parameters(base, linked, at)
                            .seen_in(past.wavelength)
                            .beside(past.other_side);
                        let frame = (normal, tangent);
                        match layers {
                            None => bsdf.add_principled(weight, &p, tables, frame),
                            Some(layers) => {
                                let normals = (normal, &side as &dyn Fn(Vec3) -> Vec3);
                                let layers = layers_at(layers, normals, at);
                                bsdf.add_layered(weight, (&p, &layers), tables, frame);
                            }
                        }
                    }
                    Shader::Diffuse {
                        color,
                        roughness,
                        rules,
                        ..
                    } => {
                        let (color, roughness) = (reflected(at.color(color)), at.number(roughness));
                        bsdf.add_diffuse(weight, color, (roughness, *rules), normal);
                    }
                    Shader::Simple {
                        bsdf: kind,
                        sockets,
                        ..
                    } => {
                        let values = SimpleValues {
                            kind: *kind,
                            sockets,
                            weight,
                            space: self.space,
                            other_side: past.other_side,
                        };
                        bsdf.add_simple(&values, at, tables, (normal, tangent));
                    }
                    Shader::Glossy {
                        color,
                        roughness,
                        anisotropy,
                        rotation,
                        distribution,
                        ..
                    } => {
                        let facets = (at.number(roughness), at.number(anisotropy));
                        let color = reflected(at.color(color));
                        let tangent = tangent.map(|t| turned(t, normal, at.number(rotation)));
                        bsdf.add_glossy(weight, color, facets, (normal, tangent), *distribution);
                    }
                }
            }
        });
    }

    /// What the material says where it has no textures.
    #[inline]
    pub fn constant_parameters(&self) -> &Principled {
        &self.base
    }

    /// Sets of texture coordinates that its textures read.
    pub fn uv_sets(&self) -> usize {
        // Where there are no tangents, those of the first set take their place.
        let bumps = usize::from(self.tangents().0);
        let sets = self.programs().map(Program::uv_sets);
        sets.fold(bumps, usize::max)
    }

    fn asked(&self) -> impl Iterator<Item = PlaceInput> {
        // What covers a light keeps more of it the more it is seen from the side.
        let covers = !self.programs.emission.shining.covered.is_empty();
        let looks = covers.then_some(PlaceInput::Incoming);
        let asked = self.programs().flat_map(Program::place_inputs);
        asked.chain(looks)
    }

    /// The normal outside that takes the place of the surface's own, if it has one.
    #[inline]
    pub fn has_normal(&self) -> bool {
        self.programs.normal.is_some()
    }

    /// This normal at a point; 0 where there is none.
    #[cold]
    #[inline(never)]
    pub fn normal(&self, at: &impl Place) -> Vec3 {
        self.programs
            .normal
            .as_ref()
            .map_or(Vec3::ZERO, |(program, root)| {
                program.at(at, |at| at.color(root))
            })
    }

    /// Whether its programs do more than glTF's materials call for.
    pub fn computes(&self) -> bool {
        self.programs().any(|program| program.computes())
    }

    /// Whether its programs ask the scene by rays.
    pub fn traces(&self) -> bool {
        self.programs().any(|program| program.traces())
    }

    /// Whether its programs have Bumps that are widened.
    pub fn is_widened(&self) -> bool {
        self.programs().any(Program::is_widened)
    }

    /// Whether its programs ask about places.
    pub fn asks_about_places(&self) -> bool {
        self.asked().next().is_some()
    }

    /// Whether its programs ask for generated coordinates.
    pub fn reads_generated(&self) -> bool {
        self.asked().any(|input| {
            matches!(
                input,
                PlaceInput::Generated | PlaceInput::Tangent | PlaceInput::RadialTangent(_)
            )
        })
    }

    /// How many attributes of vertices its programs ask for.
    pub fn attributes(&self) -> usize {
        let numbers = self.asked().map(|input| match input {
            PlaceInput::Attribute(number) => number as usize + 1,
            _ => 0,
        });
        numbers.fold(0, usize::max)
    }

    /// Whether what it emits asks the scene by rays.
    pub fn emission_traces(&self) -> bool {
        self.programs.emission.program.traces()
    }

    /// Whether what it emits or lets pass is not the same for light samples and for the rays of paths.
    pub fn asks_which_ray(&self) -> bool {
        let opacity = self.programs.opacity.iter().map(|o| &o.program);
        let mut programs = opacity.chain([&self.programs.emission.program]);
        let asks = |p: &PlaceInput| p.tells_rays_apart();
        programs.any(|program| program.place_inputs().iter().any(asks))
    }

    /// Whether it has fibres whose directions are drawn otherwise than they are evaluated.
    pub fn draws_other_fibres(&self) -> bool {
        let mut shaders = self.programs.shaders.iter();
        shaders.any(|of| of.shader.draws_other_fibres())
    }

    /// Whether [`Self::emitted`] looks at the place.
    pub fn emission_varies(&self) -> bool {
        self.programs.emission.constant().is_none()
    }

    /// Emitted radiance at a point.
    #[inline]
    pub fn emitted(&self, at: &impl Place) -> Vec3 {
        let Emission { program, shining } = &self.programs.emission;
        if program.is_constant() && shining.covered.is_empty() {
            return self.emission;
        }
        program.at(at, |evaluation| shone(shining, at, evaluation))
    }

    /// The same at a hit whose lobes are asked for next, if their program makes it; `computed` is for them.
    #[inline]
    pub fn emitted_with_lobes(
        &self,
        at: &impl Place,
        computed: &mut Option<Computed>,
    ) -> Option<Vec3> {
        let shining = self.programs.shining.as_ref()?;
        let computed = computed.get_or_insert_default();
        let ask = |evaluation: &mut Evaluation<'_, _>| shone(shining, at, evaluation);
        Some(self.programs.surface.again(at, computed, ask))
    }

    /// Adds what it tells passes of the scene's own at a point.
    pub fn add_aovs(&self, at: &impl Place, sums: &mut [f64]) {
        if let Some(aovs) = &self.programs.aovs {
            aovs.add(at, sums);
        }
    }
}

/// Emitted radiance, by the program that it is a value of.
#[inline]
fn shone<P: Place>(shining: &Shining, place: &P, at: &mut Evaluation<'_, P>) -> Vec3 {
    if shining.covered.is_empty() {
        at.color(&shining.open)
    } else {
        covered::emitted(shining, place, at)
    }
}

/// The materials of a scene, and at last the one of meshes without any.
pub fn prepare(scene: &Scene, options: &Options) -> Vec<Arc<PreparedMaterial>> {
    let mut is_placed = vec![false; scene.meshes.len()];
    for instance in &scene.instances {
        is_placed[instance.mesh.0 as usize] = true;
    }
    let mut vertices = vec![Vertices::default(); scene.materials.len() + 1];
    let placed = scene.meshes.iter().zip(&is_placed).filter(|(_, p)| **p);
    for (mesh, _) in placed.filter(|_| options.effects.contains(Effect::VertexColors)) {
        let default = scene.materials.len();
        let slot = mesh.material.map_or(default, |m| m.0 as usize);
        if let (Some(colors), Some(v)) = (&mesh.colors, vertices.get_mut(slot)) {
            v.colored |= colors.iter().flatten().any(|&c| c != 1.0);
            v.translucent |= colors.iter().any(|c| c[3] < 1.0);
        }
    }
    let estimate = if scene.is_from_blender() {
        Estimate::Cycles
    } else {
        Estimate::Exact
    };
    let mut preparer = Preparer::new(options.roughens, estimate);
    let fallback = Material::default();
    let materials = scene.materials.iter().chain([&fallback]);
    materials
        .zip(&vertices)
        .map(|(m, &v)| {
            let mut m = effects::without_effects(m, options.effects);
            if !(options.aovs || m.graph.aovs.is_empty()) {
                m.graph.aovs.clear();
                m.graph.prune();
            }
            preparer.material(scene, &m, v)
        })
        .map(Arc::new)
        .collect()
}
