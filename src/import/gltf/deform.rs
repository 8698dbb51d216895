//! Morph targets and skins, as they stand in the file: a still scene has one pose.

use ::gltf::json;
use glam::{DAffine3, DMat4, DVec3};
use json::mesh::Semantic;

use super::accessor;
use super::container::Document;
use super::mesh::Attributes;
use super::schema::SkinJson;
use crate::import::budget::Budget;
use crate::scene::{Diagnostics, Verdict};

/// How a mesh is deformed before it is placed.
#[derive(Clone, Debug, Default)]
pub(super) struct Pose {
    /// Weights of the morph targets; missing ones are 0.
    pub weights: Vec<f64>,
    /// Mesh space to the placed object's space for each joint of the skin; empty: no skin.
    pub joints: Vec<DAffine3>,
}

/// The arrays of a primitive that a pose moves.
pub(super) struct Shape<'a> {
    pub positions: &'a mut Vec<[f32; 3]>,
    pub normals: Option<&'a mut Vec<[f32; 3]>>,
    pub tangents: Option<&'a mut Vec<[f32; 4]>>,
}

/// JOINTS_n and WEIGHTS_n beyond this number are not read: 16 joints a vertex are plenty.
const JOINT_SETS: u32 = 4;

impl Pose {
    /// Reads a skin's inverse bind matrices and joins them with where its joints stand.
    ///
    /// `world` gives the joints' places, `affine` what a matrix means; the result maps to the frame of `object`.
    pub(super) fn joints(
        document: &Document,
        skin: &SkinJson,
        world: impl Fn(usize) -> Option<DAffine3>,
        object_from_world: DAffine3,
        budget: &Budget,
        mut affine: impl FnMut(&[f64; 16]) -> DAffine3,
    ) -> Result<Vec<DAffine3>, String> {
        let inverse_binds = match skin.inverse_bind_matrices {
            Some(index) => accessor::read::<16>(document, index, budget)?,
            None => Vec::new(),
        };
        if skin.inverse_bind_matrices.is_some() && inverse_binds.len() < skin.joints.len() {
            return Err(format!(
                "its skin has {} joints but {} inverse bind matrices",
                skin.joints.len(),
                inverse_binds.len()
            ));
        }
        budget.take(skin.joints.len() as u64, size_of::<DAffine3>())?;
        skin.joints
            .iter()
            .enumerate()
            .map(|(i, &joint)| {
                let stands = world(joint)
                    .ok_or_else(|| format!("its skin's joint {joint} is not in the scene"))?;
                let bind = inverse_binds.get(i).map_or(DAffine3::IDENTITY, &mut affine);
                Ok(object_from_world * stands * bind)
            })
            .collect()
    }

    /// Moves a primitive's vertices (specification 3.7.2.2 and 3.7.3.3: morph targets first).
    pub(super) fn apply(
        &self,
        document: &Document,
        attributes: &Attributes,
        mut shape: Shape,
        budget: &Budget,
    ) -> Result<OddWeights, String> {
        self.morph(document, attributes, &mut shape, budget)?;
        self.skin(document, attributes, &mut shape, budget)
    }

    fn morph(
        &self,
        document: &Document,
        attributes: &Attributes,
        shape: &mut Shape,
        budget: &Budget,
    ) -> Result<(), String> {
        let targets = attributes.primitive.targets.iter().flatten();
        for (target, &weight) in targets.zip(&self.weights).filter(|(_, w)| **w != 0.0) {
            let weight = weight as f32;
            if let Some(index) = &target.positions {
                let offsets = accessor::read_f32::<3>(document, index.value(), budget)?;
                add(shape.positions, &offsets, weight)?;
            }
            if let (Some(index), Some(normals)) = (&target.normals, &mut shape.normals) {
                let offsets = accessor::read_f32::<3>(document, index.value(), budget)?;
                add(normals, &offsets, weight)?;
            }
            if let (Some(index), Some(tangents)) = (&target.tangents, &mut shape.tangents) {
                let offsets = accessor::read_f32::<3>(document, index.value(), budget)?;
                same_length(tangents.len(), offsets.len())?;
                for (tangent, offset) in tangents.iter_mut().zip(&offsets) {
                    for (value, change) in tangent.iter_mut().zip(offset) {
                        *value += weight * change;
                    }
                }
            }
        }
        Ok(())
    }

    fn skin(
        &self,
        document: &Document,
        attributes: &Attributes,
        shape: &mut Shape,
        budget: &Budget,
    ) -> Result<OddWeights, String> {
        let mut odd = OddWeights::default();
        if self.joints.is_empty() {
            return Ok(odd);
        }
        let mut influences: Vec<[Vec<[f64; 4]>; 2]> = Vec::new();
        for set in 0..JOINT_SETS {
            let (Some(joints), Some(weights)) = (
                attributes.get(Semantic::Joints(set)),
                attributes.get(Semantic::Weights(set)),
            ) else {
                break;
            };
            let joints = accessor::read::<4>(document, joints, budget)?;
            let weights = accessor::read::<4>(document, weights, budget)?;
            same_length(shape.positions.len(), joints.len())?;
            same_length(shape.positions.len(), weights.len())?;
            influences.push([joints, weights]);
        }
        for vertex in 0..shape.positions.len() {
            let (mut blended, mut total, mut used) = (DMat4::ZERO, 0.0, 0.0);
            for [joints, weights] in &influences {
                for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                    if weight != 0.0 {
                        let matrix = self.joints.get(joint as usize).ok_or_else(|| {
                            format!("it uses joint {joint} of a skin of {}", self.joints.len())
                        })?;
                        blended += DMat4::from(*matrix) * weight;
                        total += weight;
                        used += 1.0;
                    }
                }
            }
            // Rounded to 8 bits each is off by up to half of 1/255.
            odd.scaled |= (total - 1.0).abs() > used * 0.5 / 255.0 && total != 0.0;
            odd.none |= total == 0.0;
            // A vertex that hangs on no joint, which the format forbids, stays with the first.
            let blended = match self.joints.first() {
                Some(first) if total == 0.0 => *first,
                _ => DAffine3::from_mat4(blended * (1.0 / total)),
            };
            let place = |v: &[f32]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
            let position = &mut shape.positions[vertex];
            *position = blended.transform_point3(place(position)).as_vec3().into();
            if let Some(normals) = &mut shape.normals {
                // The cofactor matrix turns normals like the inverse transpose, and needs no inverse.
                let m = blended.matrix3;
                let n = place(&normals[vertex]);
                let turned = m.y_axis.cross(m.z_axis) * n.x
                    + m.z_axis.cross(m.x_axis) * n.y
                    + m.x_axis.cross(m.y_axis) * n.z;
                normals[vertex] = turned.normalize_or_zero().as_vec3().into();
            }
            if let Some(tangents) = &mut shape.tangents {
                let turned = blended
                    .transform_vector3(place(&tangents[vertex]))
                    .normalize_or_zero()
                    .as_vec3();
                tangents[vertex] = [turned.x, turned.y, turned.z, tangents[vertex][3]];
            }
        }
        Ok(odd)
    }
}

/// What the format forbids of a skin's weights, and a mesh has.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OddWeights {
    /// The weights of a vertex do not sum to 1.
    pub scaled: bool,
    /// A vertex has none.
    pub none: bool,
}

impl OddWeights {
    pub(super) fn report(self, mesh: &str, diagnostics: &mut Diagnostics) {
        for (is_so, what, instead) in [
            (
                self.scaled,
                "weights of a skin that do not sum to 1",
                "scaled so that they do",
            ),
            (
                self.none,
                "vertices of a skin without weights",
                "moved with its first joint",
            ),
        ] {
            if is_so {
                diagnostics.report("skin-weights", Verdict::Approximated, what, mesh, instead);
            }
        }
    }
}

fn same_length(vertices: usize, values: usize) -> Result<(), String> {
    if vertices == values {
        Ok(())
    } else {
        Err(format!(
            "it has {vertices} vertices but {values} values to move them"
        ))
    }
}

fn add(values: &mut [[f32; 3]], offsets: &[[f32; 3]], weight: f32) -> Result<(), String> {
    same_length(values.len(), offsets.len())?;
    for (value, offset) in values.iter_mut().flatten().zip(offsets.iter().flatten()) {
        *value += weight * offset;
    }
    Ok(())
}
