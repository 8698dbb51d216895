//! Builds small glTF files in memory.

use std::io::Cursor;
use std::path::PathBuf;

use serde_json::{Value, json};
use sundog::import::{self, ImportError, ImportOptions, Imported};
use sundog::scene::graph::node::{self, principled};
use sundog::scene::graph::{Input, Opacity, SocketKind, Unit};
use sundog::scene::{AlphaMode, Diagnostic, Material, MetallicRoughness, NormalTexture};

pub const FLOAT: u32 = 5126;
pub const BYTE: u32 = 5120;
pub const UNSIGNED_BYTE: u32 = 5121;
pub const SHORT: u32 = 5122;
pub const UNSIGNED_SHORT: u32 = 5123;
pub const UNSIGNED_INT: u32 = 5125;

/// Blender's exporter, as it names itself.
pub const BLENDER_4_5: &str = "Khronos glTF Blender I/O v4.5.51";

/// A glTF file under construction.
#[derive(Clone, Debug)]
pub struct Builder {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Builder {
    /// A file with nothing in it.
    pub fn empty() -> Self {
        Self {
            json: json!({ "asset": { "version": "2.0" } }),
            binary: Vec::new(),
        }
    }

    /// One unit right triangle in the xy plane, in mesh 0, placed by node 0.
    pub fn triangle() -> Self {
        let mut file = Self::empty();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        file.json["meshes"] =
            json!([{ "name": "tri", "primitives": [{ "attributes": { "POSITION": positions } }] }]);
        file.json["nodes"] = json!([{ "name": "node", "mesh": 0 }]);
        file.json["scenes"] = json!([{ "nodes": [0] }]);
        file.json["scene"] = json!(0);
        file
    }

    /// A textured unit square with normals and UVs, in mesh 0 with material 0, placed by node 0.
    pub fn square() -> Self {
        let mut file = Self::triangle();
        let positions = file.floats(
            "VEC3",
            &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0],
        );
        let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
        let uvs = file.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let indices = file.accessor("SCALAR", UNSIGNED_BYTE, false, 6, &[0, 1, 2, 0, 2, 3]);
        file.json["materials"] = json!([{ "name": "paint" }]);
        file.json["meshes"][0]["primitives"] = json!([{
            "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs },
            "indices": indices,
            "material": 0
        }]);
        file
    }

    /// Appends bytes as a buffer view and returns its index.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.binary.len().is_multiple_of(4) {
            self.binary.push(0);
        }
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }),
        )
    }

    /// Appends an accessor with a view of its own.
    pub fn accessor(
        &mut self,
        kind: &str,
        component: u32,
        normalized: bool,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count, "normalized": normalized }),
        )
    }

    /// Appends an accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let components = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("no such kind: {other}"),
        };
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(kind, FLOAT, false, values.len() / components, &bytes)
    }

    /// Appends a PNG image, a texture of it, and returns the texture's index.
    pub fn png_texture(&mut self, pixels: image::DynamicImage) -> usize {
        let view = self.view(&png(pixels));
        let image = self.push(
            "images",
            json!({ "bufferView": view, "mimeType": "image/png" }),
        );
        self.push("textures", json!({ "source": image }))
    }

    /// Appends to one of the file's lists.
    pub fn push(&mut self, list: &str, item: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let items = self.json[list].as_array_mut().expect("a list");
        items.push(item);
        items.len() - 1
    }

    /// The file as GLB.
    pub fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.binary.is_empty() {
            json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        }
        glb(&serde_json::to_vec(&json).expect("JSON"), &self.binary)
    }

    /// Loads the file as GLB.
    pub fn load_with(&self, options: &ImportOptions) -> Result<Imported, ImportError> {
        load_bytes(&self.glb(), options)
    }

    /// Loads the file as GLB, which must succeed.
    pub fn load(&self) -> Imported {
        match self.load_with(&ImportOptions::default()) {
            Ok(imported) => imported,
            Err(error) => panic!("{error}"),
        }
    }

    /// Loads the file as GLB, which must fail; returns the message.
    pub fn error(&self) -> String {
        match self.load_with(&ImportOptions::default()) {
            Ok(_) => panic!("loaded: {}", self.json),
            Err(error) => error.to_string(),
        }
    }
}

/// Packs two chunks.
pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let pad = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, binary) = (pad(json, b' '), pad(binary, 0));
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(b"JSON");
    file.extend(json);
    if !binary.is_empty() {
        file.extend((binary.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(binary);
    }
    let total = file.len() as u32;
    file[8..12].copy_from_slice(&total.to_le_bytes());
    file
}

/// An image as the bytes of a PNG file.
pub fn png(pixels: image::DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    pixels
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("PNG");
    bytes.into_inner()
}

/// Loads a file with these bytes.
pub fn load_bytes(bytes: &[u8], options: &ImportOptions) -> Result<Imported, ImportError> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("test.glb");
    std::fs::write(&path, bytes).expect("a file");
    import::load(&path, options)
}

/// A new folder and the path of a file in it.
pub fn place(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    (folder, path)
}

/// The diagnostics with this code.
pub fn found<'a>(imported: &'a Imported, code: &str) -> Vec<&'a Diagnostic> {
    imported
        .diagnostics
        .iter()
        .filter(|d| d.code == code)
        .collect()
}

/// All codes, in order.
pub fn codes(imported: &Imported) -> Vec<&'static str> {
    imported.diagnostics.iter().map(|d| d.code).collect()
}

/// What a graph made of glTF's material says, in glTF's own words.
pub fn standard(material: &Material) -> MetallicRoughness {
    let graph = &material.graph;
    let results = graph.results(&mut Unit {
        vertex_alpha: false,
    });
    let summary = material.summary();
    let shader = graph.node(graph.body().unwrap());
    let first = |input: Input| graph.textures_behind(input).next().cloned();
    let socket = |at: usize| shader.inputs[at];
    let number = |input: Input| {
        graph
            .range_of(&results, input, SocketKind::Float)
            .number()
            .1
    };
    let mut m = MetallicRoughness {
        name: material.name.clone(),
        double_sided: material.double_sided,
        unlit: summary.unlit,
        emission: summary.emission.to_array(),
        ..MetallicRoughness::default()
    };
    if summary.unlit {
        m.base_color = m.emission;
        m.base_color_texture = first(socket(node::emission::COLOR));
    } else {
        let p = &summary.principled[0];
        m.base_color = p.base_color.to_array();
        m.base_color_texture = first(socket(principled::BASE_COLOR));
        (m.metallic, m.roughness) = (p.metallic.1, p.roughness.1);
        m.metallic_roughness_texture =
            first(socket(principled::METALLIC)).or(first(socket(principled::ROUGHNESS)));
        m.emission_texture = first(socket(principled::EMISSION_COLOR));
        (m.ior, m.specular, m.transmission) = (p.ior.1, p.specular.1, p.transmission.1);
        m.specular_texture = first(socket(principled::SPECULAR_IOR_LEVEL));
        let tint = socket(principled::SPECULAR_TINT);
        let tint_range = graph.range_of(&results, tint, SocketKind::Color);
        m.specular_color = tint_range.high.truncate().to_array();
        m.specular_color_texture = first(tint);
        m.transmission_texture = first(socket(principled::TRANSMISSION_WEIGHT));
        m.thin_walled = p.thin_wall;
        let thickness = number(socket(principled::THIN_FILM_THICKNESS));
        let film = || [thickness, number(socket(principled::THIN_FILM_IOR))];
        m.thin_film = (thickness > 0.0).then(film);
        m.normal_texture = first(socket(principled::NORMAL)).map(|texture| NormalTexture {
            texture,
            scale: graph.normal_map_strengths().next().unwrap(),
        });
    }
    if let Some((at, ..)) = graph.transparency() {
        let factor = graph.nodes[at].inputs[node::mix_shader::FACTOR];
        (m.alpha_mode, m.alpha) = match summary.opacity {
            Opacity::Clip { cutoff, .. } => {
                let hole = graph.node(factor.link().unwrap());
                (
                    AlphaMode::Mask { cutoff },
                    number(hole.inputs[node::math::A]),
                )
            }
            _ => (AlphaMode::Blend, number(factor)),
        };
    }
    m
}
