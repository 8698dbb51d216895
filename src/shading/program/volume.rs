//! What fills space at a point, by a node tree.

use super::compile::{Compiler, Source, root};
use super::{Evaluation, Known, Place, Program, Root};
use crate::scene::graph::function::PlaceInput;
use crate::scene::graph::node::{
    emission, principled_volume, volume_absorption, volume_coefficients, volume_scatter,
};
use crate::scene::graph::{self, Graph, NodeKind, PhaseKind, VolumeShader};
use crate::scene::{Interpolation, Phase};
use glam::Vec3;

/// The shaders of a volume.
#[derive(Clone, Debug)]
pub struct VolumeProgram {
    program: Program,
    parts: Vec<Part>,
    /// The grids that it reads.
    grids: Vec<(u32, Interpolation)>,
    /// Whether nothing else of the place counts.
    of_grids_alone: bool,
    asks_about: AsksAbout,
}

/// What a volume asks about that is not of the place alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct AsksAbout {
    /// The kind of the ray.
    pub kinds: bool,
    /// How often its path was scattered.
    pub depths: bool,
    /// Where it goes.
    pub directions: bool,
    /// The camera.
    pub view: bool,
}

/// A shader with its share of the whole.
#[derive(Clone, Debug)]
struct Part {
    weight: Root,
    /// None for an Emission.
    shader: Option<VolumeShader>,
    sockets: Vec<Root>,
}

/// As in Cycles: beyond it the phase function is a needle that f32 cannot tell from the straight way.
const MOST_G: f32 = 1.0 - 1e-3;

impl VolumeProgram {
    /// Compiles the volume of a graph.
    pub fn new(graph: &Graph, mut known: Known, source: &mut impl Source) -> Self {
        let mut folded = graph.clone();
        graph::fold(&mut folded, &mut known);
        let mut heights = 0;
        let mut compiler = Compiler::new(&folded, source, &mut heights);
        let mut parts = Vec::new();
        for (at, weight) in compiler.leaves(folded.volume) {
            let shader = match folded.nodes[at].kind {
                NodeKind::Volume(shader) => Some(shader),
                NodeKind::Emission => None,
                // Shaders of surfaces fill nothing.
                _ => continue,
            };
            let count = folded.nodes[at].inputs.len();
            let sockets = (0..count).map(|socket| root(compiler.color_input(at, socket)));
            parts.push(Part {
                weight: root(weight),
                shader,
                sockets: sockets.collect(),
            });
        }
        let roots = parts.iter_mut().flat_map(|part| {
            let Part {
                weight, sockets, ..
            } = part;
            std::iter::once(weight).chain(sockets)
        });
        let mut roots: Vec<&mut Root> = roots.collect();
        let program = compiler.finish(&mut roots);
        let (mut grids, mut of_grids_alone) = (Vec::new(), true);
        let mut asks_about = AsksAbout::default();
        for input in program.place_inputs() {
            asks_about.note(input);
            match input {
                PlaceInput::Grid {
                    number,
                    interpolation,
                    ..
                } if !grids.contains(&(number, interpolation)) => {
                    grids.push((number, interpolation));
                }
                PlaceInput::Grid { .. }
                | PlaceInput::ObjectLocation
                | PlaceInput::ObjectColor
                | PlaceInput::ObjectAlpha
                | PlaceInput::ObjectIndex
                | PlaceInput::ObjectRandom
                | PlaceInput::ObjectValue(_)
                | PlaceInput::MaterialIndex(_) => {}
                _ => of_grids_alone = false,
            }
        }
        Self {
            program,
            parts,
            of_grids_alone: of_grids_alone && !grids.is_empty(),
            grids,
            asks_about,
        }
    }

    /// The grids that it reads, by their numbers, each with how.
    pub fn grids(&self) -> &[(u32, Interpolation)] {
        &self.grids
    }

    /// Whether it depends on the place by these alone.
    pub fn is_of_grids_alone(&self) -> bool {
        self.of_grids_alone
    }

    /// Whether any of the shaders scatters light, whatever their numbers are.
    pub fn scatters(&self) -> bool {
        let scatters = |shader| !matches!(shader, VolumeShader::Absorption);
        let mut shaders = self.parts.iter().filter_map(|part| part.shader);
        shaders.any(scatters)
    }

    /// What it asks about that is not of the place alone.
    pub fn asks_about(&self) -> AsksAbout {
        self.asks_about
    }

    /// What is taken, 1/m, and emitted, W·sr⁻¹·m⁻³, at a place; `scatterer` gets what is scattered, 1/m, and how.
    /// `density`: what all is multiplied with that volume shaders say.
    pub fn at<P: Place>(
        &self,
        place: &P,
        density: f32,
        mut scatterer: impl FnMut(Vec3, Phase),
    ) -> (Vec3, Vec3) {
        self.program.at(place, |at| {
            let (mut absorption, mut emission) = (Vec3::ZERO, Vec3::ZERO);
            for part in &self.parts {
                let weight = at.number(&part.weight);
                if weight > 0.0 {
                    let weight = weight * part.shader.map_or(1.0, |_| density);
                    let (taken, emitted) = part.at(weight, at, &mut scatterer);
                    absorption += taken;
                    emission += emitted;
                }
            }
            (absorption, emission)
        })
    }
}

impl AsksAbout {
    fn note(&mut self, input: PlaceInput) {
        match input {
            PlaceInput::IsRay(_) | PlaceInput::IsSingularRay | PlaceInput::IsReflectionRay => {
                self.kinds = true;
            }
            PlaceInput::RayDepth | PlaceInput::PathDepth(_) => self.depths = true,
            PlaceInput::Incoming
            | PlaceInput::Normal
            | PlaceInput::TrueNormal
            | PlaceInput::ObjectNormal
            | PlaceInput::Reflection => self.directions = true,
            input => self.view |= input.is_of_view(),
        }
    }
}

/// What cannot be below zero; what is not a number stays so.
fn positive(value: Vec3) -> Vec3 {
    Vec3::select(value.cmplt(Vec3::ZERO), Vec3::ZERO, value)
}

impl Part {
    fn at<P: Place>(
        &self,
        weight: f32,
        at: &mut Evaluation<'_, P>,
        scatterer: &mut impl FnMut(Vec3, Phase),
    ) -> (Vec3, Vec3) {
        let mut color = |socket: usize| positive(at.color(&self.sockets[socket]));
        match self.shader {
            None => {
                // Of less than nothing too, as in Cycles.
                let [color, strength] = [emission::COLOR, emission::STRENGTH]
                    .map(|socket| at.color(&self.sockets[socket]));
                (Vec3::ZERO, color * strength * weight)
            }
            Some(VolumeShader::Absorption) => {
                let density = weight * color(volume_absorption::DENSITY).x;
                let clear = color(volume_absorption::COLOR);
                (positive(1.0 - clear) * density, Vec3::ZERO)
            }
            Some(VolumeShader::Scatter(kind)) => {
                let density = weight * color(volume_scatter::DENSITY).x;
                if density > 0.0 {
                    let color = color(volume_scatter::COLOR);
                    let phase = self.phase(kind, volume_scatter::ANISOTROPY, at);
                    scatterer(color * density, phase);
                }
                (Vec3::ZERO, Vec3::ZERO)
            }
            Some(VolumeShader::Coefficients(kind)) => {
                let [absorbed, scattered] = [
                    volume_coefficients::ABSORPTION,
                    volume_coefficients::SCATTER,
                ]
                .map(|socket| color(socket) * weight);
                let emitted = at.color(&self.sockets[volume_coefficients::EMISSION]) * weight;
                let phase = self.phase(kind, volume_coefficients::ANISOTROPY, at);
                scatterer(scattered, phase);
                (absorbed, emitted)
            }
            Some(VolumeShader::Principled) => {
                let density = weight * color(principled_volume::DENSITY).x;
                let emitted = color(principled_volume::EMISSION_COLOR)
                    * color(principled_volume::EMISSION_STRENGTH)
                    * weight;
                if density <= 0.0 {
                    return (Vec3::ZERO, emitted);
                }
                let white = color(principled_volume::COLOR);
                let clear = color(principled_volume::ABSORPTION_COLOR);
                let root = Vec3::from(clear.to_array().map(f32::sqrt));
                let absorbed = positive(1.0 - white) * positive(1.0 - root) * density;
                let hg = PhaseKind::HenyeyGreenstein;
                let phase = self.phase(hg, principled_volume::ANISOTROPY, at);
                scatterer(white * density, phase);
                (absorbed, emitted)
            }
        }
    }

    fn phase<P: Place>(
        &self,
        kind: PhaseKind,
        anisotropy: usize,
        at: &mut Evaluation<'_, P>,
    ) -> Phase {
        // Anisotropy, index, share that goes back, alpha, diameter: both shaders have them in this order.
        let mut number = |further: usize| at.number(&self.sockets[anisotropy + further]);
        match kind {
            PhaseKind::HenyeyGreenstein => {
                Phase::HenyeyGreenstein(number(0).clamp(-MOST_G, MOST_G))
            }
            PhaseKind::Rayleigh => Phase::Rayleigh,
            PhaseKind::Draine => Phase::Draine {
                anisotropy: number(0).clamp(-MOST_G, MOST_G),
                alpha: number(3).max(0.0),
            },
            PhaseKind::FournierForand => Phase::FournierForand {
                ior: number(1),
                backscatter: number(2),
            },
            PhaseKind::Mie => Phase::Mie(number(4)),
        }
    }
}
