//! Draco, meshopt and KTX2: what was encoded comes back, and damage is an error in words.

use super::kit::*;
use draco_core::{
    DataType, EncoderBuffer, EncoderOptions, GeometryAttributeType, Mesh, MeshEncoder,
    PointAttribute,
};
use meshoptimizer_rs::Workspace;
use meshoptimizer_rs::codec::{self, ExpMode, IndexEncoding, VertexEncoding};
use serde_json::{Value, json};
use sundog::import::{ImportOptions, decode_image};
use sundog::scene::Pixels;

/// Side of the grid of vertices.
const SIDE: usize = 6;

/// Positions, texture coordinates and triangles.
type Grid = (Vec<[f32; 3]>, Vec<[f32; 2]>, Vec<[u32; 3]>);

fn grid() -> Grid {
    let at = |i: usize| (i % SIDE, i / SIDE);
    let positions = (0..SIDE * SIDE)
        .map(|i| {
            [
                at(i).0 as f32,
                at(i).1 as f32,
                (20.0 * (i as f32 * 0.7).sin()).round() / 20.0,
            ]
        })
        .collect();
    let uvs = (0..SIDE * SIDE)
        .map(|i| [at(i).0 as f32 / 5.0, at(i).1 as f32 / 5.0])
        .collect();
    let triangles = (0..SIDE * SIDE)
        .filter(|&i| at(i).0 + 1 < SIDE && at(i).1 + 1 < SIDE)
        .flat_map(|i| {
            let (a, b, c, d) = (i, i + 1, i + SIDE, i + SIDE + 1);
            [[a, b, d], [a, d, c]].map(|t| t.map(|v| v as u32))
        })
        .collect();
    (positions, uvs, triangles)
}

fn bytes<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect()
}

/// A stream with texture coordinates as attribute 7 and positions as attribute 3, in this order.
fn draco(method: i32) -> Vec<u8> {
    let (positions, uvs, triangles) = grid();
    let mut mesh = Mesh::new();
    mesh.set_num_points(positions.len());
    let mut add = |kind, components, data: Vec<u8>, id| {
        let mut attribute = PointAttribute::new();
        attribute.init(kind, components, DataType::Float32, false, positions.len());
        attribute.buffer_mut().write(0, &data);
        attribute.set_unique_id(id);
        mesh.add_attribute_preserve_unique_id(attribute);
    };
    add(GeometryAttributeType::TexCoord, 2, bytes(&uvs), 7);
    add(GeometryAttributeType::Position, 3, bytes(&positions), 3);
    mesh.try_set_num_faces(triangles.len()).unwrap();
    for (index, triangle) in triangles.iter().enumerate() {
        mesh.set_face_from_indices(index, *triangle);
    }
    let mut options = EncoderOptions::new();
    options.set_encoding_method(method);
    options.set_attribute_quantization(0, 14);
    options.set_attribute_quantization(1, 14);
    let mut encoder = MeshEncoder::new();
    encoder.set_mesh(mesh);
    let mut out = EncoderBuffer::new();
    encoder.encode(&options, &mut out).unwrap();
    out.data().to_vec()
}

/// A file with that stream and nothing else of the mesh.
fn draco_file(stream: &[u8]) -> Builder {
    let mut file = Builder::triangle();
    let view = file.view(stream);
    let count = SIDE * SIDE;
    let empty = |file: &mut Builder, kind: &str, component: u32, count: usize| {
        file.push(
            "accessors",
            json!({ "componentType": component, "type": kind, "count": count }),
        )
    };
    let positions = empty(&mut file, "VEC3", FLOAT, count);
    let uvs = empty(&mut file, "VEC2", FLOAT, count);
    let indices = empty(&mut file, "SCALAR", UNSIGNED_SHORT, grid().2.len() * 3);
    file.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    file.json["meshes"][0]["primitives"] = json!([{
        "attributes": { "POSITION": positions, "TEXCOORD_0": uvs },
        "indices": indices,
        "extensions": { "KHR_draco_mesh_compression": {
            "bufferView": view, "attributes": { "POSITION": 3, "TEXCOORD_0": 7 }
        } }
    }]);
    file
}

/// Corners as numbers that do not hang on their order: position and texture coordinates in 1/100.
fn corners(positions: &[[f32; 3]], uvs: &[[f32; 2]], triangles: &[[u32; 3]]) -> Vec<[[i32; 5]; 3]> {
    let round = |v: f32| (v * 100.0).round() as i32;
    let mut all: Vec<_> = triangles
        .iter()
        .map(|t| {
            let mut corners = t.map(|i| {
                let ([x, y, z], [u, v]) = (positions[i as usize], uvs[i as usize]);
                [x, y, z, u, v].map(round)
            });
            let least = (0..3).min_by_key(|&i| corners[i]).unwrap();
            corners.rotate_left(least);
            corners
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn draco_gives_back_the_mesh_by_unique_ids() {
    let (positions, uvs, triangles) = grid();
    let meant = corners(&positions, &uvs, &triangles);
    // Sequential, and by the edgebreaker.
    for method in [0, 1] {
        let imported = draco_file(&draco(method)).load();
        let mesh = &imported.scene.meshes[0];
        assert!(imported.diagnostics.is_empty());
        // A step of 14 bits over a range of 5 is 0.0003; the grid's values are multiples of 0.05.
        assert_eq!(
            corners(&mesh.positions, &mesh.uvs[0], &mesh.triangles),
            meant,
            "method {method}"
        );
    }
}

#[test]
fn draco_mixes_with_plain_attributes_and_morph_targets() {
    // In a sequential stream the vertices keep their order.
    let mut file = draco_file(&draco(0));
    let count = SIDE * SIDE;
    let colors = file.floats("VEC4", &[0.25, 0.5, 0.75, 1.0].repeat(count));
    let lift = file.floats("VEC3", &[0.0, 0.0, 2.0].repeat(count));
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["COLOR_0"] = json!(colors);
    primitive["targets"] = json!([{ "POSITION": lift }]);
    file.json["meshes"][0]["weights"] = json!([0.5]);
    let mesh = file.load().scene.meshes.remove(0);
    assert_eq!(mesh.colors.unwrap(), vec![[0.25, 0.5, 0.75, 1.0]; count]);
    for (there, meant) in mesh.positions.iter().zip(grid().0) {
        assert!((there[2] - meant[2] - 1.0).abs() < 1e-3);
    }
}

#[test]
fn draco_counts_are_held_against_the_accessors() {
    let file = draco_file(&draco(1));
    for (accessor, what) in [("POSITION", "elements"), ("indices", "triangles")] {
        let mut file = file.clone();
        let primitive = &file.json["meshes"][0]["primitives"][0];
        let index = match accessor {
            "indices" => &primitive["indices"],
            name => &primitive["attributes"][name],
        };
        let index = index.as_u64().unwrap() as usize;
        file.json["accessors"][index]["count"] = json!(9);
        let error = file.error();
        assert!(
            error.contains("mesh \"tri\"") && error.contains(what),
            "{error}"
        );
    }
    // A count without memory behind it.
    let mut file = file;
    for accessor in file.json["accessors"].as_array_mut().unwrap() {
        accessor["count"] = json!(3_000_000_000u32);
    }
    assert!(file.error().contains("out of proportion"));
}

#[test]
fn damaged_draco_is_an_error_or_the_plain_copy() {
    let stream = draco(1);
    let mut file = draco_file(&stream[..stream.len() / 2]);
    assert!(file.error().contains("its Draco data are damaged"));
    let mut plain = draco_file(&stream[..stream.len() / 2]);
    let (positions, _, triangles) = grid();
    let positions: Vec<f32> = positions.into_iter().flatten().collect();
    let positions = plain.floats("VEC3", &positions);
    let indices: Vec<u8> = triangles.iter().flatten().map(|&i| i as u8).collect();
    let indices = plain.accessor("SCALAR", UNSIGNED_BYTE, false, indices.len(), &indices);
    let primitive = &mut plain.json["meshes"][0]["primitives"][0];
    primitive["attributes"] = json!({ "POSITION": positions });
    primitive["indices"] = json!(indices);
    let imported = plain.load();
    assert_eq!(codes(&imported), ["compression-fallback"]);
    assert_eq!(imported.scene.meshes[0].triangles, triangles);
    file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = json!(3);
    assert!(file.error().contains("cannot be read"));
}

/// Numbers without a pattern.
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Damages some bytes, or cuts the end off.
fn damage(bytes: &[u8], state: &mut u64) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random(state) % 4 {
        let at = random(state) as usize % bytes.len();
        match random(state) % 4 {
            0 => bytes[at] ^= 1 << (random(state) % 8),
            1 => bytes[at] = 255,
            2 => bytes[at] = random(state) as u8,
            _ => bytes.truncate(at.max(1)),
        }
    }
    bytes
}

#[test]
fn damaged_streams_end_in_a_scene_or_an_error() {
    let mut state = 17;
    let (mut read, mut refused) = (0, 0);
    for round in 0..400 {
        let file = match round % 3 {
            0 => draco_file(&damage(&draco(round / 3 % 2), &mut state)),
            1 => {
                let (mut file, range) = meshopt_file("EXT_meshopt_compression", 0);
                let damaged = damage(&file.binary[range.clone()], &mut state);
                file.binary[range.start..range.start + damaged.len()].copy_from_slice(&damaged);
                file
            }
            _ => {
                let damaged = damage(&ktx2(round % 2 == 0), &mut state);
                match decode_image(&damaged, "damaged") {
                    Ok(_) => read += 1,
                    Err(_) => refused += 1,
                }
                continue;
            }
        };
        match file.load_with(&ImportOptions::default()) {
            Ok(_) => read += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(read > 20 && refused > 20, "{read} read, {refused} refused");
}

/// The grid with its positions (as exponents), normals (octahedral), colours and indices compressed; also where
/// the streams are.
fn meshopt_file(name: &str, version: u8) -> (Builder, std::ops::Range<usize>) {
    let (positions, _, triangles) = grid();
    let count = positions.len();
    let mut work = Workspace::default();
    let encoding = VertexEncoding::new(version, 2).unwrap();
    let flat: Vec<f32> = positions.iter().flatten().copied().collect();
    let exponents =
        codec::encode_filter_exp(count, 12, 20, &flat, ExpMode::Separate, &mut work).unwrap();
    let up: Vec<f32> = [0.6, 0.0, 0.8, 0.0].repeat(count);
    let normals = codec::encode_filter_oct(count, 4, 8, &up, &mut work).unwrap();
    let paint: Vec<f32> = [0.2, 0.4, 0.8, 1.0].repeat(count);
    let colors = codec::encode_filter_color(count, 4, 8, &paint, &mut work).unwrap();
    let indices: Vec<u32> = triangles.iter().flatten().copied().collect();
    let mut file = Builder::triangle();
    let start = file.binary.len();
    let mut add = |stream: Vec<u8>, stride: usize, items: usize, mode: &str, filter: &str| {
        let at = file.view(&stream);
        let inner = file.json["bufferViews"][at].clone();
        file.json["bufferViews"][at] = json!({
            "buffer": 0, "byteLength": 1, "byteStride": if mode == "ATTRIBUTES" { json!(stride) } else { Value::Null },
            "extensions": { name: {
                "buffer": 0, "byteOffset": inner["byteOffset"], "byteLength": stream.len(),
                "byteStride": stride, "count": items, "mode": mode, "filter": filter
            } }
        });
        at
    };
    let mut attribute = |raw: &[u8], stride, filter| {
        let stream = codec::encode_vertex_buffer(raw, count, stride, encoding, &mut work).unwrap();
        add(stream, stride, count, "ATTRIBUTES", filter)
    };
    let views = [
        attribute(&exponents, 12, "EXPONENTIAL"),
        attribute(&normals, 4, "OCTAHEDRAL"),
        attribute(&colors, 4, if version == 1 { "COLOR" } else { "NONE" }),
    ];
    let mut work = Workspace::default();
    let stream = codec::encode_index_buffer(&indices, IndexEncoding::DEFAULT, &mut work).unwrap();
    let triangles_view = add(stream, 4, indices.len(), "TRIANGLES", "NONE");
    let stream = codec::encode_index_sequence(&indices, IndexEncoding::DEFAULT, &mut work).unwrap();
    let sequence_view = add(stream, 4, indices.len(), "INDICES", "NONE");
    let end = file.binary.len();
    let mut accessor = |view: usize, component: u32, kind: &str, count: usize, normalized: bool| {
        file.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": kind, "count": count, "normalized": normalized }),
        )
    };
    let attributes = json!({
        "POSITION": accessor(views[0], FLOAT, "VEC3", count, false),
        "NORMAL": accessor(views[1], BYTE, "VEC3", count, true),
        "COLOR_0": accessor(views[2], UNSIGNED_BYTE, "VEC4", count, true),
    });
    let sets = [triangles_view, sequence_view]
        .map(|view| accessor(view, UNSIGNED_INT, "SCALAR", indices.len(), false));
    file.json["extensionsRequired"] = json!([name]);
    file.json["meshes"][0]["primitives"] = json!([
        { "attributes": attributes, "indices": sets[0] },
        { "attributes": attributes, "indices": sets[1] }
    ]);
    (file, start..end)
}

#[test]
fn meshopt_gives_back_every_mode_and_filter() {
    let (positions, _, triangles) = grid();
    for (name, version) in [
        ("EXT_meshopt_compression", 0),
        ("KHR_meshopt_compression", 1),
    ] {
        let scene = meshopt_file(name, version).0.load().scene;
        assert_eq!(scene.meshes.len(), 2);
        let uvs = vec![[0.0; 2]; positions.len()];
        for mesh in &scene.meshes {
            assert_eq!(
                corners(&mesh.positions, &uvs, &mesh.triangles),
                corners(&positions, &uvs, &triangles)
            );
            // Eight bits of an octahedron: a step of 1/127, some 0.9°.
            for normal in mesh.normals.as_ref().unwrap() {
                assert!(normal[0] * 0.6 + normal[2] * 0.8 > 0.999);
            }
            for color in mesh
                .colors
                .as_ref()
                .unwrap()
                .iter()
                .filter(|_| version == 1)
            {
                for (there, meant) in color.iter().zip([0.2, 0.4, 0.8, 1.0]) {
                    assert!((there - meant).abs() < 0.02, "{color:?}");
                }
            }
        }
        // A sequence keeps its order.
        assert_eq!(scene.meshes[1].triangles, triangles);
    }
}

#[test]
fn quaternions_of_instances_come_through_meshopt() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut work = Workspace::default();
    let turned: Vec<f32> = [0.0, half, 0.0, half].repeat(4);
    let raw = codec::encode_filter_quat(4, 8, 12, &turned, &mut work).unwrap();
    let encoding = VertexEncoding::new(0, 2).unwrap();
    let stream = codec::encode_vertex_buffer(&raw, 4, 8, encoding, &mut work).unwrap();
    let mut file = Builder::triangle();
    let view = file.view(&stream);
    let offset = file.json["bufferViews"][view]["byteOffset"].clone();
    file.json["bufferViews"][view] = json!({ "buffer": 0, "byteLength": 32, "byteStride": 8,
        "extensions": { "EXT_meshopt_compression": { "buffer": 0, "byteOffset": offset, "byteLength": stream.len(),
            "byteStride": 8, "count": 4, "mode": "ATTRIBUTES", "filter": "QUATERNION" } } });
    let rotations = file.push(
        "accessors",
        json!({ "bufferView": view, "componentType": SHORT, "type": "VEC4", "count": 4, "normalized": true }),
    );
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "ROTATION": rotations } } });
    let scene = file.load().scene;
    assert_eq!(scene.instances.len(), 4);
    for instance in &scene.instances {
        // A quarter turn about Y takes X to −Z; twelve bits of a quaternion.
        assert!((instance.world_from_object.matrix3.x_axis.z + 1.0).abs() < 2e-3);
    }
}

#[test]
fn meshopt_headers_are_not_believed() {
    let (file, _) = meshopt_file("EXT_meshopt_compression", 0);
    let view = file.json["bufferViews"]
        .as_array()
        .unwrap()
        .iter()
        .position(|v| v["extensions"].is_object())
        .unwrap();
    for (key, value, says) in [
        ("count", json!(4_000_000_000u64), "out of proportion"),
        ("mode", json!("WAVELETS"), "WAVELETS"),
        ("filter", json!("SMOOTH"), "SMOOTH"),
        ("byteLength", json!(1_000_000), "beyond the end"),
        ("byteStride", json!(7), "damaged"),
        ("buffer", json!(9), "no buffer 9"),
    ] {
        let mut file = file.clone();
        file.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"][key] = value;
        let error = file.error();
        assert!(
            error.contains(says) && error.contains("tri"),
            "{key}: {error}"
        );
    }
}

/// Colours of the four blocks of the test's texture.
const BLOCKS: [[u8; 4]; 4] = [
    [255, 0, 0, 255],
    [0, 255, 0, 128],
    [0, 0, 255, 255],
    [9, 99, 199, 64],
];

/// 7 × 6 pixels of UASTC in blocks of one colour each (mode 8), with Zstandard around it if wanted.
fn ktx2(zstandard: bool) -> Vec<u8> {
    let blocks: Vec<u8> = BLOCKS
        .iter()
        .flat_map(|c| (23u128 | u128::from(u32::from_le_bytes(*c)) << 5).to_le_bytes())
        .collect();
    let level = if zstandard {
        // A frame of one raw block, its size in one byte (RFC 8878, 3.1.1).
        let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0x20, blocks.len() as u8];
        let head = 1 | (blocks.len() as u32) << 3;
        frame.extend(&head.to_le_bytes()[..3]);
        frame.extend(&blocks);
        frame
    } else {
        blocks.clone()
    };
    let mut file = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let scheme = if zstandard { 2 } else { 0 };
    let (dfd, start) = (104u32, 148u64);
    for word in [0, 1, 7, 6, 0, 0, 1, 1, scheme, dfd, 44, 0, 0] {
        file.extend(word.to_le_bytes());
    }
    for long in [0, 0, start, level.len() as u64, blocks.len() as u64] {
        file.extend(long.to_le_bytes());
    }
    // Basic descriptor: UASTC (166), Rec.709, sRGB; blocks of 4 × 4 in 16 bytes; one sample, of RGBA (3).
    let kind = 166 | 1 << 8 | 2 << 16;
    for word in [
        44u32,
        0,
        2 | 40 << 16,
        kind,
        3 | 3 << 8,
        16,
        0,
        127 << 16 | 3 << 24,
        0,
        0,
        u32::MAX,
    ] {
        file.extend(word.to_le_bytes());
    }
    file.extend(level);
    file
}

#[test]
fn ktx2_is_read_with_and_without_zstandard() {
    for zstandard in [false, true] {
        let image = decode_image(&ktx2(zstandard), "blocks").unwrap();
        assert_eq!((image.width, image.height, image.channels), (7, 6, 4));
        let Pixels::U8(pixels) = &image.pixels else {
            panic!("8 bits a channel")
        };
        for (at, pixel) in pixels.chunks_exact(4).enumerate() {
            let block = (at / 7 / 4) * 2 + at % 7 / 4;
            assert_eq!(pixel, BLOCKS[block], "{at}");
        }
    }
}

#[test]
fn ktx2_textures_are_used_and_what_they_say_of_their_size_is_checked() {
    let mut file = Builder::square();
    let view = file.view(&ktx2(true));
    let image = file.push(
        "images",
        json!({ "bufferView": view, "mimeType": "image/ktx2" }),
    );
    let texture = file.push(
        "textures",
        json!({ "extensions": { "KHR_texture_basisu": { "source": image } } }),
    );
    file.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    file.json["materials"][0]["pbrMetallicRoughness"] =
        json!({ "baseColorTexture": { "index": texture } });
    let imported = file.load();
    assert!(imported.diagnostics.is_empty());
    assert!(
        standard(&imported.scene.materials[0])
            .base_color_texture
            .is_some()
    );
    assert_eq!(imported.scene.images[0].width, 7);
    for (at, value) in [
        (20usize, 1u32 << 31),
        (20, 60_000),
        (96, 1 << 30),
        (88, 1 << 30),
        (36, 6),
    ] {
        let mut damaged = ktx2(false);
        damaged[at..at + 4].copy_from_slice(&value.to_le_bytes());
        assert!(decode_image(&damaged, "damaged").is_err(), "{at}");
    }
}
