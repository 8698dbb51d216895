//! Tables of the albedos of materials' dielectrics.

use super::material::{Preparer, tables_of};
use crate::scene::graph::node::{glass, principled, principled_hair};
use crate::scene::graph::{
    Distribution, HairFibre, HairModel, PrincipledSummary, ShaderRules, SimpleBsdf,
};
use crate::scene::{Material, Scene};
use crate::shading::dielectrics::Needs;
use crate::shading::program::{Root, Shader, Weighted};
use crate::shading::tables::{Indices, Rows};
use crate::shading::{Dielectrics, Principled, ggx};
use glam::Vec3;
use std::sync::Arc;

/// Tables of a material's dielectrics.
#[derive(Debug)]
pub struct AlbedoTables {
    /// Of the first one.
    pub dielectrics: Arc<Dielectrics>,
    /// By shader, where it is not one Principled BSDF.
    pub(super) mixed: Vec<Arc<Dielectrics>>,
}

impl Preparer {
    /// Tables of a material beside something of an index.
    pub(super) fn albedo_tables(
        &self,
        (p, linked): (Option<&PrincipledSummary>, &[(usize, Root)]),
        shaders: &[Weighted],
        beside: f32,
    ) -> AlbedoTables {
        AlbedoTables {
            dielectrics: self.dielectrics(p, linked, beside),
            mixed: self.mixed(shaders, beside),
        }
    }

    /// Tables of a material that takes part in the order of solids, by the indices of all those.
    pub(super) fn in_solids(
        &self,
        scene: &Scene,
        material: &Material,
        first: (Option<&PrincipledSummary>, &[(usize, Root)]),
        shaders: &[Weighted],
    ) -> Vec<(f32, AlbedoTables)> {
        if material.nested().is_none() {
            return Vec::new();
        }
        let others = scene.materials.iter().filter_map(Material::nested);
        let mut indices: Vec<f32> = others.map(|(_, index)| index.ior()).collect();
        indices.sort_by(f32::total_cmp);
        indices.dedup();
        let tables = |index: f32| (index, self.albedo_tables(first, shaders, index));
        indices.into_iter().map(tables).collect()
    }

    /// Whether the tables of a material's solid are read: smooth ones need none, nor does what is metal everywhere (textures scale
    /// the factor down).
    fn needs_solid(&self, p: &PrincipledSummary) -> bool {
        let roughness = p.roughness.1;
        let rough = self.roughens() || roughness * roughness > ggx::SMOOTH_ALPHA;
        rough && !p.is_metal_everywhere() && p.transmission.1 > 0.0 && !p.thin_wall
    }

    fn dielectrics(
        &self,
        p: Option<&PrincipledSummary>,
        linked: &[(usize, Root)],
        beside: f32,
    ) -> Arc<Dielectrics> {
        let is_linked = |socket: usize| linked.iter().any(|(of, _)| *of == socket);
        let (least, greatest) = p.map_or((1.5, 1.5), |p| p.ior);
        let indices = if is_linked(principled::IOR) {
            Indices::Between(least / beside, greatest / beside)
        } else {
            Indices::One(greatest / beside)
        };
        // Images of floats may hold more than 1.
        // With anisotropy the mean of both roughnesses is less where one of them ends at 1.
        let rules = p.map_or(ShaderRules::default(), |p| p.rules);
        let is_long = rules == ShaderRules::Since53 && p.is_some_and(|p| p.anisotropy > 0.0);
        let rough = is_linked(principled::ROUGHNESS) || is_long;
        let roughness = p.map_or(1.0, |p| p.roughness.1);
        let rows = Rows::between(
            if rough { 0.0 } else { roughness },
            if rough || self.roughens() {
                1.0
            } else {
                roughness
            },
        );
        tables_of(Needs {
            solid: p.is_some_and(|p| self.needs_solid(p)).then_some(indices),
            rows,
            estimate: self.estimate(rules),
            below_one: self.estimate_of_file(),
        })
    }

    /// Tables of several shaders, or of another than a Principled BSDF; none for one Principled BSDF.
    fn mixed(&self, shaders: &[Weighted], beside: f32) -> Vec<Arc<Dielectrics>> {
        let is_plain = |weighted: &Weighted| {
            weighted.weight.constant() == Some(Vec3::ONE)
                && matches!(
                    weighted.shader,
                    Shader::Principled {
                        base: Principled { below: None, .. },
                        tangent: None,
                        layers: None,
                        ..
                    }
                )
        };
        if shaders.is_empty() || shaders.len() == 1 && is_plain(&shaders[0]) {
            return Vec::new();
        }
        let tables = |shader: &Shader| match shader {
            Shader::Principled { base, linked, .. } => {
                let p = summary_of(base, linked);
                self.dielectrics(Some(&p), linked, beside)
            }
            Shader::Simple { bsdf, sockets, .. } => self.simple(*bsdf, sockets, beside),
            Shader::Diffuse { .. } | Shader::Glossy { .. } => self.dielectrics(None, &[], 1.0),
        };
        shaders.iter().map(|w| tables(&w.shader)).collect()
    }

    /// Tables of the solid of a Glass BSDF.
    fn simple(&self, bsdf: SimpleBsdf, sockets: &[Root], beside: f32) -> Arc<Dielectrics> {
        let rules = match bsdf {
            SimpleBsdf::Glass {
                distribution: Distribution::MultiscatterGgx,
                rules,
            } => rules,
            SimpleBsdf::PrincipledHair(HairFibre {
                model: HairModel::Huang,
                ..
            }) => return self.fibre(sockets),
            _ => return self.dielectrics(None, &[], 1.0),
        };
        let number = |socket: usize| sockets[socket].constant().map(|c| c.x);
        let share = |socket: usize| number(socket).map(|c| c.clamp(0.0, 1.0));
        // With anisotropy the mean of both roughnesses is less where one of them ends at 1.
        let is_round = number(glass::ANISOTROPY) == Some(0.0);
        let roughness = share(glass::ROUGHNESS).filter(|_| is_round);
        let indices = match number(glass::IOR) {
            Some(ior) => Indices::One(ior / beside),
            None => Indices::Between(0.0, ANY_INDEX / beside),
        };
        let rows = Rows::between(
            roughness.unwrap_or(0.0),
            roughness.filter(|_| !self.roughens()).unwrap_or(1.0),
        );
        tables_of(Needs {
            solid: Some(indices),
            rows,
            estimate: self.estimate(rules),
            below_one: self.estimate_of_file(),
        })
    }

    /// Tables of the boundary of a fibre of facets, whose roughness is α itself.
    fn fibre(&self, sockets: &[Root]) -> Arc<Dielectrics> {
        let number = |socket: usize| sockets[socket].constant().map(|c| c.x);
        let roughness = number(principled_hair::ROUGHNESS)
            .filter(|_| number(principled_hair::RANDOM_ROUGHNESS) == Some(0.0))
            .map(|alpha| alpha.clamp(0.001, 1.0).sqrt());
        tables_of(Needs {
            solid: Some(match number(principled_hair::IOR) {
                Some(ior) => Indices::One(ior),
                None => Indices::Between(0.0, ANY_INDEX),
            }),
            rows: Rows::between(
                roughness.unwrap_or(0.0),
                roughness.filter(|_| !self.roughens()).unwrap_or(1.0),
            ),
            estimate: self.estimate(ShaderRules::default()),
            below_one: self.estimate_of_file(),
        })
    }
}

/// Above what links to an index say.
const ANY_INDEX: f32 = 4.0;

/// What is known of a shader among others: numbers that are linked may be anything.
fn summary_of(base: &Principled, linked: &[(usize, Root)]) -> PrincipledSummary {
    let range = |socket: usize, known: f32, most: f32| {
        let is_linked = linked.iter().any(|(of, _)| *of == socket);
        if is_linked {
            (0.0, most)
        } else {
            (known, known)
        }
    };
    PrincipledSummary {
        base_color: base.base_color,
        metallic: range(principled::METALLIC, base.metallic, 1.0),
        roughness: range(principled::ROUGHNESS, base.roughness, 1.0),
        anisotropy: range(principled::ANISOTROPIC, base.anisotropy, 1.0).1,
        ior: range(principled::IOR, base.ior, ANY_INDEX),
        specular: range(principled::SPECULAR_IOR_LEVEL, base.specular, 2.0),
        transmission: range(principled::TRANSMISSION_WEIGHT, base.transmission, 1.0),
        disperses: range(principled::DISPERSION, base.dispersion, 1.0).1 > 0.0,
        thin_wall: base.thin_walled,
        rules: base.rules,
    }
}
