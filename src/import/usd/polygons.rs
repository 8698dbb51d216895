//! Polygons with values on them, as USD has them.

use std::collections::BTreeMap;

/// What a value of a layer belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// All of the mesh.
    Constant,
    /// A face.
    Uniform,
    /// A point.
    Vertex,
    /// A corner of a face.
    FaceVarying,
}

/// Values on a mesh.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// Numbers of each.
    pub components: usize,
    pub values: Vec<f32>,
    pub interpolation: Interpolation,
    /// Which values they are, if they are not all of them in their order.
    pub indices: Option<Vec<u32>>,
}

/// A place on the mesh: a corner of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub face: usize,
    /// Among all corners.
    pub number: usize,
    pub point: u32,
}

impl Layer {
    /// Which of the values a corner has.
    pub(super) fn index(&self, corner: Corner) -> usize {
        let place = match self.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Uniform => corner.face,
            Interpolation::Vertex => corner.point as usize,
            Interpolation::FaceVarying => corner.number,
        };
        match &self.indices {
            Some(indices) => indices.get(place).map_or(0, |i| *i as usize),
            None => place,
        }
    }

    /// The value of that number, of which only so many components count; what is missing is taken from `rest`.
    pub(super) fn at<const N: usize>(&self, index: usize, rest: [f32; N]) -> [f32; N] {
        let start = index * self.components;
        let mut value = rest;
        let given = self.values.get(start..start + self.components);
        for (to, from) in value.iter_mut().zip(given.unwrap_or_default()) {
            *to = *from;
        }
        value
    }
}

/// Polygons.
#[derive(Clone, Debug)]
pub(super) struct Polygons {
    pub points: Vec<[f32; 3]>,
    /// Corners of each face.
    pub counts: Vec<usize>,
    /// The point of each corner.
    pub corners: Vec<u32>,
    /// Faces that are not there.
    pub hole: Vec<bool>,
    /// Faces are seen clockwise from their front.
    pub left_handed: bool,
    pub normals: Option<Layer>,
    /// Points have normals of their own, made of those of the faces about them.
    pub smooth: bool,
    /// They are the cage of a subdivision surface.
    pub subdivides: bool,
    pub primvars: BTreeMap<String, Layer>,
}

impl Polygons {
    /// Some points and no faces yet.
    pub(super) fn new(points: Vec<[f32; 3]>) -> Self {
        Self {
            points,
            counts: Vec::new(),
            corners: Vec::new(),
            hole: Vec::new(),
            left_handed: false,
            normals: None,
            smooth: false,
            subdivides: false,
            primvars: BTreeMap::new(),
        }
    }

    /// Adds a face.
    pub(super) fn face(&mut self, corners: &[u32]) {
        self.counts.push(corners.len());
        self.corners.extend(corners);
        self.hole.push(false);
    }

    /// So many values a layer has to have.
    pub(super) fn wanted(&self, interpolation: Interpolation) -> usize {
        match interpolation {
            Interpolation::Constant => 1,
            Interpolation::Uniform => self.counts.len(),
            Interpolation::Vertex => self.points.len(),
            Interpolation::FaceVarying => self.corners.len(),
        }
    }

    /// The first corner of each face.
    pub(super) fn starts(&self) -> Vec<usize> {
        let starts = self.counts.iter().scan(0, |next, count| {
            let start = *next;
            *next += count;
            Some(start)
        });
        starts.collect()
    }
}
