//! Triangles: without area, like needles, twice, broken, one and ten million.

use super::{Case, Effort, Finding};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use std::sync::atomic::{AtomicU32, Ordering};
use sundog::import::{self, ImportOptions};
use sundog::math::float;
use sundog::render::{LightSampling, RenderError, RenderSettings};
use sundog::sampler::hashed;
use sundog::scene::validate::clean;
use sundog::scene::{
    Diagnostics, Image, ImageId, Mesh, MetallicRoughness, NormalTexture, RayKind, Scene, Texture,
    Visibility,
};
use sundog::selftest::kit::{
    Bench, camera, colors, constant_environment, differing, diffuse, mean, place, prepared, quad,
    small, sphere,
};
use sundog::selftest::light_leaks::{leaks, meet};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        name: "broken-triangles",
        about: "Triangles without area, with vertices that are not finite or do not exist: left out, and the rest keeps its bits.",
        run: broken_triangles,
    },
    Case {
        name: "duplicated-triangles",
        about: "Each triangle of a mesh twice, and a mesh that stands twice in its place: the same picture.",
        run: duplicated_triangles,
    },
    Case {
        name: "slivers",
        about: "A band of 20 km cut into strips of a tenth of a millimetre, 1 to 2e8: no ray passes between them, and they are as bright as the band.",
        run: slivers,
    },
    Case {
        name: "zero-normals-and-tangents",
        about: "Vertex normals and tangents that are 0, NaN or infinite: computed anew, and the picture is that of good ones.",
        run: zero_normals_and_tangents,
    },
    Case {
        name: "collapsed-uvs",
        about: "A normal map on texture coordinates that are all the same: the surface keeps its normals.",
        run: collapsed_uvs,
    },
    Case {
        name: "too-many-indices",
        about: "Small files that claim 2^31 indices or more, or whose indices end at 2^32: refused with a sentence, or without the triangle, and without the memory.",
        run: too_many_indices,
    },
    Case {
        name: "one-triangle-and-millions",
        about: "Meshes of one triangle, and of 16 thousand (640 thousand with more effort, 10 million with the most): closed, and all of each can be hit.",
        run: one_triangle_and_millions,
    },
];

/// Directions as the surface scatters, and no light samples: under a sky of 1 each sample of a plane that reflects half
/// of it is 1/2, but for the roundings of its weight.
fn by_chance(samples: u32) -> RenderSettings {
    RenderSettings {
        light_sampling: LightSampling::Bsdf,
        ..small(samples, 1)
    }
}

fn ball_at(x: f64) -> DAffine3 {
    DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.8),
        DQuat::from_rotation_x(0.4),
        DVec3::new(x, 0.0, -3.0),
    )
}

/// A mesh under a sky of 1, before the camera.
fn shown(mesh: Mesh, material: MetallicRoughness) -> Scene {
    let mut scene = Scene {
        environment: constant_environment(1.0),
        ..Scene::default()
    };
    place(&mut scene, mesh, material, &[ball_at(0.0)]);
    scene.cameras.push(camera(DVec3::ZERO, 0.7));
    scene
}

fn broken_triangles(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 32, 256), 3);
    let whole = sphere(16, 0.2, true);
    let mut broken = whole.clone();
    let first = broken.positions.len() as u32;
    let strange = [
        [f32::NAN, 0.0, 0.0],
        [0.0, f32::INFINITY, 0.0],
        [0.0, 0.0, f32::NEG_INFINITY],
        [2.0, 2.0, 2.0],
        [4.0, 4.0, 4.0],
    ];
    broken.positions.extend(strange);
    let like = |values: &mut Vec<[f32; 3]>| values.extend([[0.0, 1.0, 0.0]; 5]);
    broken.normals.iter_mut().for_each(like);
    broken
        .uvs
        .iter_mut()
        .for_each(|set| set.extend([[0.0; 2]; 5]));
    let bad = [
        [first, 1, 2],
        [3, first + 1, 4],
        [5, 6, first + 2],
        // The same corner twice and thrice; corners in a row.
        [7, 7, 8],
        [9, 9, 9],
        [first + 3, first + 4, first + 3],
        // Vertices that do not exist.
        [1, 2, first + 5],
        [u32::MAX, 1 << 31, 3],
    ];
    for (i, triangle) in bad.into_iter().enumerate() {
        broken.triangles.insert(i * 20, triangle);
    }
    let (mut good, mut mended) = (
        shown(whole, diffuse([0.7; 3])),
        shown(broken, diffuse([0.7; 3])),
    );
    let (mut nothing, mut diagnostics) = (Diagnostics::default(), Diagnostics::default());
    clean(&mut good, &mut nothing);
    clean(&mut mended, &mut diagnostics);
    let told = |code: &str| diagnostics.iter().any(|d| d.code == code);
    let codes = [
        "bad-indices",
        "non-finite-positions",
        "degenerate-triangles",
    ];
    let silent = codes.iter().filter(|code| !told(code)).count() as u64;
    let mut bench = Bench::default();
    let expected = bench.render(&good, &settings)?.picture;
    let found = bench.render(&mended, &settings)?.picture;
    let left = mended.meshes[0]
        .triangles
        .len()
        .abs_diff(good.meshes[0].triangles.len()) as u64;
    Ok(bench.with(vec![
        Finding::none("triangles too many or too few", left),
        Finding::none("reasons that were not told", silent),
        Finding::none("pixels that differ", differing(&found, &expected)),
    ]))
}

fn duplicated_triangles(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 32, 256), 3);
    let once = sphere(16, 0.2, true);
    let mut twice = once.clone();
    twice.triangles.extend(once.triangles.clone());
    let mut bench = Bench::default();
    let expected = bench
        .render(&shown(once.clone(), diffuse([0.7; 3])), &settings)?
        .picture;
    let found = bench
        .render(&shown(twice.clone(), diffuse([0.7; 3])), &settings)?
        .picture;
    let plain = differing(&found, &expected);
    // As light each copy would be sampled, and one of them met: one of each is kept.
    let shining = MetallicRoughness {
        emission: [1.0; 3],
        ..diffuse([0.0; 3])
    };
    let mut lit = [&once, &twice].map(|mesh| shown(mesh.clone(), shining.clone()));
    let [once_lit, twice_lit] = &mut lit;
    clean(once_lit, &mut Diagnostics::default());
    clean(twice_lit, &mut Diagnostics::default());
    let lit_once = bench.render(once_lit, &settings)?.picture;
    let found = bench.render(twice_lit, &settings)?.picture;
    // And so would objects in one place: the same mesh placed twice, and one with a mesh of its own.
    let mut beside = shown(once.clone(), shining.clone());
    beside.instances.push(beside.instances[0].clone());
    place(&mut beside, once, shining.clone(), &[ball_at(0.0)]);
    clean(&mut beside, &mut Diagnostics::default());
    let beside = bench.render(&beside, &settings)?.picture;
    // Turned over, with two sides and with one, and hidden from rays that see the other. The points of a triangle that is
    // turned over round elsewhere, and with them the densities of light that is met: γ(64) as for other radiances.
    let lamp = |double_sided, copies: &[(bool, Visibility)]| {
        let shining = MetallicRoughness {
            double_sided,
            ..shining.clone()
        };
        let mut scene = Scene::default();
        let floor = quad([-4.0, -1.0, -1.0], [8.0, 0.0, 0.0], [0.0, 0.0, -8.0]);
        place(&mut scene, floor, diffuse([0.8; 3]), &[DAffine3::IDENTITY]);
        for &(turned, visibility) in copies {
            let mut lamp = quad([-0.5, -0.6, -3.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
            if turned {
                lamp.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            }
            place(&mut scene, lamp, shining.clone(), &[DAffine3::IDENTITY]);
            if let Some(instance) = scene.instances.last_mut() {
                instance.visibility = visibility;
            }
        }
        scene.cameras.push(camera(DVec3::ZERO, 1.2));
        clean(&mut scene, &mut Diagnostics::default());
        scene
    };
    let all = Visibility::ALL;
    let behind = all.without(RayKind::Camera).without(RayKind::Glossy);
    let alone = bench.render(&lamp(true, &[(false, all)]), &settings)?;
    let expected: Vec<f64> = colors(&alone.picture).flatten().collect();
    let mut turned = Vec::new();
    for (name, double_sided, other) in [
        ("turned over", true, (true, all)),
        ("turned over, with one side each", false, (true, all)),
        ("hidden from the camera", true, (false, behind)),
    ] {
        let scene = lamp(double_sided, &[(false, all), other]);
        let found = bench.render(&scene, &settings)?.picture;
        let off = colors(&found)
            .flatten()
            .zip(&expected)
            .map(|(found, expected)| (found - expected).abs() / expected.max(1e-3))
            .fold(0.0, f64::max);
        let bound = f64::from(float::gamma(64));
        turned.push(Finding::at_most(
            format!("relative difference of a lamp and its twin, {name}"),
            bound,
            off,
        ));
    }
    let findings = bench.with(vec![
        Finding::none(
            "pixels that differ where objects shine in one place",
            differing(&beside, &lit_once),
        ),
        Finding::none("pixels that differ", plain),
        Finding::none(
            "pixels that differ where they shine",
            differing(&found, &lit_once),
        ),
    ]);
    turned.extend(findings);
    Ok(turned)
}

/// A band from -10 km to 10 km along x and 1 cm wide, at z = -1, cut into strips; it faces +z.
fn band(strips: u32) -> Mesh {
    let mut mesh = Mesh {
        name: "band".into(),
        ..Mesh::default()
    };
    for i in 0..=strips {
        let y = 0.01 * i as f32 / strips as f32 - 0.005;
        mesh.positions.extend([[-1e4, y, -1.0], [1e4, y, -1.0]]);
    }
    for i in 0..strips {
        let a = 2 * i;
        mesh.triangles
            .extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
    }
    mesh
}

fn slivers(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    const STRIPS: u32 = 100;
    let rays: u32 = effort.of(50_000, 1_000_000, 100_000_000);
    let settings = by_chance(effort.of(16, 128, 1024));
    let mut bench = Bench::default();
    let lit = |mesh: Mesh, material| {
        let mut scene = Scene {
            environment: constant_environment(1.0),
            ..Scene::default()
        };
        place(&mut scene, mesh, material, &[DAffine3::IDENTITY]);
        scene.cameras.push(camera(DVec3::ZERO, 0.009));
        scene
    };
    let world = prepared(&lit(band(STRIPS), diffuse([0.5; 3])))?;
    let missed = (0..rays)
        .filter(|&i| {
            let number = |d| hashed(d, i, 21) - 0.5;
            let to = Vec3::new(2e3 * number(0), 0.00999 * number(1), -1.0);
            let from = Vec3::new(2.0 * number(2), number(3), 0.0);
            meet(&world, from, to - from).is_none()
        })
        .count() as u64;
    let picture = bench
        .render(&lit(band(STRIPS), diffuse([0.5; 3])), &settings)?
        .picture;
    let gray = mean(&picture);
    Ok(bench.with(vec![
        Finding::none("rays that passed between strips", missed),
        Finding::new(
            "radiance of the strips",
            0.5,
            gray,
            0.5 * f64::from(float::gamma(64)),
        ),
    ]))
}

fn zero_normals_and_tangents(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 32, 256), 3);
    // Of a plane, so that what is computed from the faces is known.
    let good = quad([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let with = |normals: [[f32; 3]; 4], tangents: [[f32; 4]; 4]| {
        let mesh = Mesh {
            normals: Some(normals.to_vec()),
            tangents: Some(tangents.to_vec()),
            ..good.clone()
        };
        let mut scene = shown(mesh, diffuse([0.7; 3]));
        let mut diagnostics = Diagnostics::default();
        clean(&mut scene, &mut diagnostics);
        scene
    };
    let (n, t) = ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]);
    let reference = with([n; 4], [t; 4]);
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let mut bench = Bench::default();
    let expected = bench.render(&reference, &settings)?.picture;
    let mut findings = Vec::new();
    for (name, normals, tangents) in [
        ("0", [[0.0; 3]; 4], [[0.0; 4]; 4]),
        (
            "not finite",
            [[nan; 3], [inf, 0.0, 0.0], n, [0.0, nan, 1.0]],
            [[nan; 4], t, [inf; 4], t],
        ),
        (
            "1e-30 long",
            [[0.0, 0.0, 1e-30]; 4],
            [[1e-30, 0.0, 0.0, 1.0]; 4],
        ),
    ] {
        let scene = with(normals, tangents);
        let mesh = &scene.meshes[0];
        let wrong = |v: &&[f32; 3]| Vec3::from(**v) != Vec3::from(n);
        let turned = mesh.normals.iter().flatten().filter(wrong).count() as u64;
        findings.push(Finding::none(
            format!("normals that are not those of the faces, {name}"),
            turned,
        ));
        let long = |t: &&[f32; 4]| !Vec3::new(t[0], t[1], t[2]).is_normalized();
        let long = mesh.tangents.iter().flatten().filter(long).count() as u64;
        findings.push(Finding::none(
            format!("tangents that are not of length 1, {name}"),
            long,
        ));
        let found = bench.render(&scene, &settings)?.picture;
        findings.push(Finding::none(
            format!("pixels that differ, {name}"),
            differing(&found, &expected),
        ));
    }
    Ok(bench.with(findings))
}

fn collapsed_uvs(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let settings = small(effort.of(4, 32, 256), 3);
    let mut mesh = sphere(16, 0.2, true);
    mesh.uvs[0].iter_mut().for_each(|uv| *uv = [0.3, 0.7]);
    let tilted = Image {
        name: "tilted".into(),
        width: 1,
        height: 1,
        channels: 3,
        pixels: vec![0.9f32, 0.6, 0.7].into(),
    };
    let texture = Texture::from(ImageId(0));
    let mapped = MetallicRoughness {
        normal_texture: Some(NormalTexture {
            texture,
            scale: 1.0,
        }),
        ..diffuse([0.7; 3])
    };
    let mut with_map = shown(mesh.clone(), mapped);
    with_map.images.push(tilted);
    let mut bench = Bench::default();
    let expected = bench
        .render(&shown(mesh, diffuse([0.7; 3])), &settings)?
        .picture;
    let found = bench.render(&with_map, &settings)?.picture;
    let differing = differing(&found, &expected);
    Ok(bench.with(vec![Finding::none("pixels that differ", differing)]))
}

/// An accessor without a buffer is zeros, which need no bytes in the file.
fn too_many_indices(_: Effort) -> Result<Vec<Finding>, RenderError> {
    let file = |count: u64| {
        serde_json::json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [
                {"componentType": 5126, "type": "VEC3", "count": 3, "min": [0, 0, 0], "max": [0, 0, 0]},
                {"componentType": 5125, "type": "SCALAR", "count": count},
            ],
        })
        .to_string()
    };
    let refused = |loaded: Result<import::Imported, import::ImportError>| {
        let sentence = loaded.err().map(|error| error.to_string());
        sentence
            .is_some_and(|s| s.contains("accessor") || s.contains("memory") || s.contains("buffer"))
    };
    let mut findings = Vec::new();
    for count in [1u64 << 31, 1 << 32, 3 << 40, u64::MAX] {
        let clear = refused(load_as("gltf", file(count).as_bytes())?);
        findings.push(Finding::new(
            format!("files of {count} indices refused with a reason"),
            1.0,
            f64::from(u8::from(clear)),
            0.0,
        ));
    }
    // Binary files with a triangle and its three indices in 48 bytes, of which one number or the last index is another.
    let large = |count: u64| serde_json::json!(count);
    for (what, pointer, number, last) in [
        ("no lie", "", 0, 2),
        ("an index of 2^31", "", 0, 1 << 31),
        ("an index of 2^32 - 1", "", 0, u32::MAX),
        ("2^31 indices", "/accessors/1/count", 1 << 31, 2),
        ("2^32 + 3 indices", "/accessors/1/count", (1 << 32) + 3, 2),
        ("2^62 indices", "/accessors/1/count", 1 << 62, 2),
        ("2^64 - 1 indices", "/accessors/1/count", u64::MAX, 2),
        ("2^31 vertices", "/accessors/0/count", 1 << 31, 2),
        ("2^62 vertices", "/accessors/0/count", 1 << 62, 2),
        (
            "indices from 2^63 on",
            "/accessors/1/byteOffset",
            1 << 63,
            2,
        ),
        (
            "a view of 2^33 bytes",
            "/bufferViews/1/byteLength",
            1 << 33,
            2,
        ),
        (
            "a view from 2^64 - 4 on",
            "/bufferViews/1/byteOffset",
            u64::MAX - 3,
            2,
        ),
        (
            "a buffer of 2^33 bytes",
            "/buffers/0/byteLength",
            1 << 33,
            2,
        ),
        (
            "2^31 sparse indices",
            "/accessors/1/sparse/count",
            1 << 31,
            2,
        ),
    ] {
        let mut tree = serde_json::json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "buffers": [{"byteLength": 48}],
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": 36},
                {"buffer": 0, "byteOffset": 36, "byteLength": 12},
            ],
            "accessors": [
                {"bufferView": 0, "byteOffset": 0, "componentType": 5126, "type": "VEC3", "count": 3,
                    "min": [0, 0, 0], "max": [1, 1, 0]},
                {"bufferView": 1, "byteOffset": 0, "componentType": 5125, "type": "SCALAR", "count": 3},
            ],
        });
        if pointer.contains("sparse") {
            tree["accessors"][1]["sparse"] = serde_json::json!({
                "count": 1, "indices": {"bufferView": 1, "componentType": 5125}, "values": {"bufferView": 1},
            });
        }
        if let Some(value) = tree.pointer_mut(pointer).filter(|_| !pointer.is_empty()) {
            *value = large(number);
        }
        let mut bytes = Vec::new();
        for corner in [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
            bytes.extend(corner.iter().flat_map(|c| c.to_le_bytes()));
        }
        bytes.extend([0, 1, last].iter().flat_map(|i: &u32| i.to_le_bytes()));
        let loaded = load_as("glb", &binary(&tree.to_string(), &bytes))?;
        let right = match &loaded {
            Ok(loaded) if pointer.is_empty() => {
                let meshes = &loaded.scene.meshes;
                let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
                triangles == usize::from(last == 2)
            }
            _ => !pointer.is_empty() && refused(loaded),
        };
        findings.push(Finding::new(
            format!("binary files with {what} read or refused as they should be"),
            1.0,
            f64::from(u8::from(right)),
            0.0,
        ));
    }
    Ok(findings)
}

/// A binary glTF file of a tree and the bytes of its buffer (specification 4.4).
fn binary(tree: &str, buffer: &[u8]) -> Vec<u8> {
    let tree = format!(
        "{tree}{}",
        " ".repeat(tree.len().next_multiple_of(4) - tree.len())
    );
    let mut file = b"glTF".to_vec();
    let word = |file: &mut Vec<u8>, n: usize| file.extend((n as u32).to_le_bytes());
    word(&mut file, 2);
    word(&mut file, 28 + tree.len() + buffer.len());
    for (kind, chunk) in [(b"JSON", tree.as_bytes()), (b"BIN\0", buffer)] {
        word(&mut file, chunk.len());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// What becomes of a file with such an ending.
fn load_as(
    ending: &str,
    bytes: &[u8],
) -> Result<Result<import::Imported, import::ImportError>, RenderError> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let name = format!("sundog-selftest-{}-{number}.{ending}", std::process::id());
    let path = std::env::temp_dir().join(name);
    let written = std::fs::write(&path, bytes);
    let loaded = import::load(&path, &ImportOptions::default());
    // Nothing is lost if it stays.
    let _ = std::fs::remove_file(&path);
    written.map_err(|error| RenderError::Setting(format!("{}: {error}", path.display())))?;
    Ok(loaded)
}

fn one_triangle_and_millions(effort: Effort) -> Result<Vec<Finding>, RenderError> {
    let mut bench = Bench::default();
    let mut findings = Vec::new();
    let one = Mesh {
        name: "one".into(),
        positions: vec![[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let picture = bench
        .render(&shown(one, diffuse([0.5; 3])), &by_chance(4))?
        .picture;
    let bound = 0.5 * f64::from(float::gamma(64));
    findings.push(Finding::new(
        "radiance of one triangle under a sky of 1",
        0.5,
        mean(&picture),
        bound,
    ));
    let rings = effort.of(64, 400, 1600);
    let mut scene = Scene::default();
    let count = 4 * u64::from(rings) * u64::from(rings) - 4 * u64::from(rings);
    place(
        &mut scene,
        sphere(rings, 0.3, false),
        diffuse([0.5; 3]),
        &[ball_at(0.0)],
    );
    scene.cameras.push(camera(DVec3::ZERO, 1.0));
    let world = prepared(&scene)?;
    findings.push(Finding::new(
        "triangles",
        count as f64,
        world.triangles() as f64,
        0.0,
    ));
    let paths = effort.of(4_000, 100_000, 1_000_000);
    findings.extend(leaks(&world, ball_at(0.0).translation.as_vec3(), paths).findings("the mesh"));
    // Centres of triangles from first to last, seen from the middle of their own cap.
    let corners = |triangle: u32| {
        let mesh = &scene.meshes[0];
        mesh.triangles[triangle as usize].map(|i| {
            let p = Vec3::from(mesh.positions[i as usize]).as_dvec3();
            ball_at(0.0).transform_point3(p).as_vec3()
        })
    };
    let mut wrong = 0;
    for i in 0..1000 {
        let triangle = (count - 1) * i / 999;
        let [a, b, c] = corners(triangle as u32);
        let middle = (a + b + c) / 3.0;
        let inwards =
            ((b - a).cross(c - a)).normalize() * (b - a).length().max((c - a).length()) * -0.1;
        let hit = meet(&world, middle + inwards, -inwards);
        wrong += u64::from(hit.is_none_or(|hit| u64::from(hit.primitive) != triangle));
    }
    findings.push(Finding::none("triangles of 1000 that were not met", wrong));
    Ok(bench.with(findings))
}
