//! A small glTF file with something of all that importers read.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::io::Cursor;

/// The document and what its buffer holds; `own`: with Sundog's extensions.
pub fn document(own: bool) -> (Value, Vec<u8>) {
    let mut bytes = buffer();
    let images = ["png", "webp"].map(|kind| {
        let picture = picture(kind);
        let place = [bytes.len(), picture.len()];
        bytes.extend(&picture);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        place
    });
    let mut document = plain(images);
    if own {
        extend(&mut document);
    }
    (document, bytes)
}

/// The bytes of a .glb or .gltf file.
pub fn written(mut document: Value, buffer: &[u8], binary: bool) -> Vec<u8> {
    if let Some(members) = document.as_object_mut() {
        let mut one = json!({ "byteLength": buffer.len() });
        if !binary {
            let data = STANDARD.encode(buffer);
            one["uri"] = json!(format!("data:application/octet-stream;base64,{data}"));
        }
        members.insert("buffers".into(), json!([one]));
    }
    let mut text = document.to_string().into_bytes();
    if !binary {
        return text;
    }
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(word(12 + 8 + text.len() + 8 + buffer.len()));
    bytes.extend(word(text.len()));
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(word(buffer.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

/// Sundog's own extensions (docs/gltf-extensions.md), each property once.
fn extend(document: &mut Value) {
    let seen = json!({ "camera": true, "diffuse": true, "glossy": false, "transmission": true, "shadow": true });
    let lights = "/extensions/KHR_lights_punctual/lights";
    let used = ["light", "object", "camera", "scene", "material"].map(|on| format!("SUNDOG_{on}"));
    for (at, name, value) in [
        (
            format!("{lights}/0"),
            "light",
            json!({ "strength": [1, 0.9, 0.8], "radius": 0.1, "soft_falloff": true,
            "visibility": seen, "max_bounces": 3, "mis": true }),
        ),
        (
            format!("{lights}/1"),
            "light",
            json!({ "strength": [1, 1, 1], "radius": 0.05, "half_angle": 0.7, "blend": 0.3 }),
        ),
        (
            format!("{lights}/2"),
            "light",
            json!({ "strength": [1, 1, 1], "angle": 0.01 }),
        ),
        (
            "/nodes/6".into(),
            "light",
            json!({ "type": "area", "shape": "ellipse", "size": [0.5, 0.3], "strength": [1, 1, 1],
            "power": 2, "normalize": false, "spread": 2.5, "name": "Area", "visibility": seen, "max_bounces": 9 }),
        ),
        (
            "/nodes/0".into(),
            "object",
            json!({ "visibility": seen, "holdout": false, "shadow_catcher": false }),
        ),
        (
            "/cameras/0".into(),
            "camera",
            json!({ "window": [-0.5, 0.6, -0.4, 0.4], "clip": [0.1, 50],
            "aperture": { "radius": 0.01, "blades": 5, "rotation": 0.1, "ratio": 1.5, "focus_distance": 3 } }),
        ),
        (
            "/cameras/1".into(),
            "camera",
            json!({ "panorama": { "type": "equirectangular", "longitude": [-3, 3], "latitude": [-1, 1] } }),
        ),
        (
            "/scenes/0".into(),
            "scene",
            json!({
            "world": { "color": [0.1, 0.2, 0.3], "rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "visibility": seen },
            "color_management": { "exposure": 0.5, "gamma": 1.1 },
            "render": { "width": 8, "height": 6, "filter_width": 1.5, "transparent": false } }),
        ),
        (
            "/materials/0".into(),
            "material",
            json!({ "base_color": [1.2, 0.5, 0.1], "specular": 1.5, "thin_walled": false, "sheen": { "weight": 0.5, "roughness": 0.3 } }),
        ),
    ] {
        if let Some(members) = document.pointer_mut(&at).and_then(Value::as_object_mut) {
            let extensions = members.entry("extensions").or_insert_with(|| json!({}));
            extensions[format!("SUNDOG_{name}")] = value;
        }
    }
    if let Some(list) = document["extensionsUsed"].as_array_mut() {
        list.extend(used.map(Value::from));
    }
}

/// Positions, normals, coordinates, colours, corners, places of instances, and a pose.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut floats = |values: &[f32]| bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    floats(&[
        -1.0, 0.0, -1.0, -1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, -1.0,
    ]);
    floats(&[0.0, 1.0, 0.0].repeat(4));
    floats(&[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
    floats(&[1.0, 0.5, 0.5, 1.0].repeat(4));
    floats(&[0.0, 0.5, 0.0, 0.5, 1.0, 0.5]);
    floats(&[0.0, 0.1, 0.0].repeat(4));
    bytes.extend([0u16, 1, 2, 0, 2, 3].into_iter().flat_map(u16::to_le_bytes));
    bytes
}

/// Something of all that importers read; the places and lengths of the two images in the buffer.
fn plain([png, webp]: [[usize; 2]; 2]) -> Value {
    let down = [
        -std::f64::consts::FRAC_1_SQRT_2,
        0.0,
        0.0,
        std::f64::consts::FRAC_1_SQRT_2,
    ];
    let texture = json!({ "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": {
        "offset": [0.1, 0.2], "rotation": 0.3, "scale": [2.0, 1.0] } } });
    let accessor = |view: u32, kind: &str| {
        json!({ "bufferView": view, "byteOffset": 0, "componentType": 5126, "count": 4, "type": kind,
            "min": [-1, -1, -1], "max": [1, 1, 1] })
    };
    json!({
        "asset": { "version": "2.0", "generator": "fuzzer" },
        "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior",
            "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_emissive_strength",
            "EXT_mesh_gpu_instancing", "EXT_texture_webp"],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "name": "Lamp", "type": "point", "intensity": 683.0, "color": [1, 0.9, 0.8], "range": 9 },
            { "name": "Spot", "type": "spot", "intensity": 683.0, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.6 } },
            { "name": "Sun", "type": "directional", "intensity": 683.0 }
        ] } },
        "scene": 0,
        "scenes": [{ "name": "Scene", "nodes": [0, 1, 2, 3, 4, 5] }],
        "nodes": [
            { "name": "Floor", "mesh": 0, "scale": [1, 1, 1], "children": [6], "weights": [0.5] },
            { "name": "Eye", "camera": 0, "translation": [0, 3, 0], "rotation": down },
            { "name": "Lamp", "translation": [0.5, 2, 0.5], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "name": "Spot", "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,2,0,1], "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "name": "Sun", "rotation": down, "extensions": { "KHR_lights_punctual": { "light": 2 } } },
            { "name": "Many", "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 4 } } } },
            { "name": "Child", "mesh": 0, "translation": [0, 0.2, 0], "scale": [0.1, 0.1, 0.1] }
        ],
        "cameras": [
            { "type": "perspective", "perspective": { "yfov": 0.9, "aspectRatio": 1.5, "znear": 0.1, "zfar": 100 } },
            { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 10 } }
        ],
        "materials": [{
            "name": "Material", "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true,
            "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0.2, "roughnessFactor": 0.5,
                "baseColorTexture": texture, "metallicRoughnessTexture": texture },
            "normalTexture": { "index": 1, "scale": 0.5 },
            "emissiveFactor": [0.1, 0.1, 0], "emissiveTexture": texture,
            "extensions": {
                "KHR_materials_ior": { "ior": 1.4 },
                "KHR_materials_emissive_strength": { "emissiveStrength": 2 },
                "KHR_materials_specular": { "specularFactor": 0.5, "specularColorFactor": [1, 1, 1] },
                "KHR_materials_transmission": { "transmissionFactor": 0.3 },
                "KHR_materials_volume": { "thicknessFactor": 0.1, "attenuationDistance": 1, "attenuationColor": [1, 1, 1] }
            }
        }],
        "textures": [{ "source": 0, "sampler": 0 }, { "sampler": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } }],
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 33071 }],
        "images": [{ "bufferView": 7, "mimeType": "image/png", "name": "Image" },
            { "bufferView": 8, "mimeType": "image/webp", "name": "Other image" }],
        "meshes": [{ "name": "Square", "weights": [0.2], "primitives": [{ "mode": 4, "indices": 6, "material": 0,
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3 },
            "targets": [{ "POSITION": 5 }] }] }],
        "accessors": [
            accessor(0, "VEC3"), accessor(1, "VEC3"), accessor(2, "VEC2"), accessor(3, "VEC4"),
            { "bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3" },
            accessor(5, "VEC3"),
            { "bufferView": 6, "componentType": 5123, "count": 6, "type": "SCALAR",
              "sparse": { "count": 1, "indices": { "bufferView": 6, "componentType": 5123 }, "values": { "bufferView": 6 } } }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48, "byteStride": 12 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 96, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 128, "byteLength": 64 },
            { "buffer": 0, "byteOffset": 192, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 216, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 264, "byteLength": 12 },
            { "buffer": 0, "byteOffset": png[0], "byteLength": png[1] },
            { "buffer": 0, "byteOffset": webp[0], "byteLength": webp[1] }
        ]
    })
}

/// A small picture of a kind that the crate `image` writes.
pub fn picture(kind: &str) -> Vec<u8> {
    let (format, picture) = match kind {
        "hdr" => (
            image::ImageFormat::Hdr,
            image::Rgb32FImage::from_fn(16, 8, |x, y| image::Rgb([x as f32, y as f32, 0.5])).into(),
        ),
        "jpg" => (image::ImageFormat::Jpeg, rgb()),
        "webp" => (image::ImageFormat::WebP, rgb()),
        "gif" => (image::ImageFormat::Gif, rgb()),
        "bmp" => (image::ImageFormat::Bmp, rgb()),
        "tga" => (image::ImageFormat::Tga, rgb()),
        "tif" => (image::ImageFormat::Tiff, rgb()),
        _ => (image::ImageFormat::Png, rgb()),
    };
    let mut bytes = Cursor::new(Vec::new());
    // An empty file is a damaged one as well.
    let _ = picture.write_to(&mut bytes, format);
    bytes.into_inner()
}

fn rgb() -> image::DynamicImage {
    image::RgbImage::from_fn(16, 8, |x, y| {
        image::Rgb([(16 * x) as u8, (32 * y) as u8, 90])
    })
    .into()
}
