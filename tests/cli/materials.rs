//! Khronos' extensions of materials, from the file to the picture.

use super::{Folder, scene};
use serde_json::{Value, json};

/// Nothing but the square, of some material, all over the picture.
fn square(material: Value) -> Value {
    let mut document = scene();
    document["materials"] = json!([material]);
    document["scenes"] = json!([{ "nodes": [0, 1] }]);
    document["cameras"][0]["perspective"]["aspectRatio"] = json!(1.0);
    document
}

/// The mean luminance of the square in light of 1 from all around.
fn luminance(folder: &Folder, material: &Value) -> f64 {
    folder.write("scene.gltf", square(material.clone()).to_string());
    let mut arguments = vec!["render", "scene.gltf", "-o", "a.exr", "--quiet"];
    arguments.extend(["--environment-color", "1,1,1", "--samples", "256"]);
    arguments.extend(["--width", "12", "--height", "12"]);
    folder.works(&arguments);
    let text = folder.works(&["compare", "a.exr", "a.exr", "--json"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    answer["mean_luminance_a"].as_f64().unwrap()
}

/// Means over 36864 samples, whose weights are about 1.
#[test]
fn white_surfaces_of_these_materials_return_all_light() {
    let folder = Folder::new();
    let core = json!({ "metallicFactor": 0.0, "roughnessFactor": 0.3 });
    for (specular, glossiness) in [(0.5, 0.5), (1.0, 0.25), (0.0, 0.0)] {
        let of = json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "specularFactor": [specular, specular, specular], "glossinessFactor": glossiness } } });
        let found = luminance(&folder, &of);
        assert!(
            (found - 1.0).abs() < 1e-3,
            "{specular} {glossiness}: {found}"
        );
    }
    for share in [0.25, 1.0] {
        let of = json!({ "pbrMetallicRoughness": core, "extensions": {
            "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": share } } });
        let found = luminance(&folder, &of);
        assert!((found - 1.0).abs() < 1e-3, "{share}: {found}");
    }
    // A sheet of glass under a film.
    let of = json!({ "pbrMetallicRoughness": core, "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1.0 },
        "KHR_materials_iridescence": { "iridescenceFactor": 1.0 } } });
    let found = luminance(&folder, &of);
    assert!((found - 1.0).abs() < 1e-3, "{found}");
}

/// Without reflection: half of it white on this side, half of it a colour on the other.
#[test]
fn what_is_scattered_through_has_its_own_colour() {
    let folder = Folder::new();
    let found = luminance(
        &folder,
        &json!({
            "pbrMetallicRoughness": { "metallicFactor": 0.0 },
            "extensions": {
                "KHR_materials_specular": { "specularFactor": 0.0 },
                "KHR_materials_diffuse_transmission": { "diffuseTransmissionFactor": 0.5,
                    "diffuseTransmissionColorFactor": [0.0, 0.5, 1.0] }
            }
        }),
    );
    let expected = 0.2126 * 0.5 + 0.7152 * 0.75 + 0.0722;
    assert!((found - expected).abs() < 1e-3, "{found}, not {expected}");
}

/// A film on half of the surface reflects the mean of one on all of it and of none.
#[test]
fn a_film_on_a_share_of_the_surface_is_that_share_of_the_light() {
    let folder = Folder::new();
    let with = |share: f32| {
        let core = json!({ "metallicFactor": 1.0, "roughnessFactor": 0.3,
            "baseColorFactor": [0.5, 0.5, 0.5, 1.0] });
        let film = json!({ "iridescenceFactor": share, "iridescenceIor": 1.8 });
        luminance(
            &folder,
            &json!({ "pbrMetallicRoughness": core,
                "extensions": { "KHR_materials_iridescence": film } }),
        )
    };
    let [none, half, all] = [0.0, 0.5, 1.0].map(with);
    assert!((none - all).abs() > 0.1, "{none} {all}");
    assert!(
        (half - 0.5 * (none + all)).abs() < 1e-3,
        "{none} {half} {all}"
    );
}

#[test]
fn variants_are_listed_and_chosen_by_name() {
    let folder = Folder::new();
    let mut document = square(json!({ "name": "red" }));
    document["materials"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "name": "blue" }));
    document["extensions"]["KHR_materials_variants"] =
        json!({ "variants": [{ "name": "summer" }, { "name": "winter" }] });
    document["meshes"][0]["primitives"][0]["extensions"] = json!({
        "KHR_materials_variants": { "mappings": [{ "material": 1, "variants": [1] }] } });
    folder.write("scene.gltf", document.to_string());
    let info = |more: &[&str]| {
        let mut arguments = vec!["info", "scene.gltf", "--json"];
        arguments.extend(more);
        serde_json::from_str::<Value>(&folder.works(&arguments)).unwrap()
    };
    let usual = info(&[]);
    assert_eq!(usual["variants"], json!(["summer", "winter"]));
    assert_eq!(usual["materials"][0]["name"], "red");
    assert_eq!(
        info(&["--variant", "winter"])["materials"][0]["name"],
        "blue"
    );
    assert_eq!(
        info(&["--variant", "summer"])["materials"][0]["name"],
        "red"
    );
    let page = folder.works(&["info", "scene.gltf"]);
    assert!(
        page.contains("variants      \"summer\", \"winter\""),
        "{page}"
    );
    for command in [
        &["info", "scene.gltf"][..],
        &["render", "scene.gltf", "-o", "a.exr"],
        &["cost", "scene.gltf"],
    ] {
        let asked = [command, &["--variant", "spring"]].concat();
        folder.fails(&asked, 1, &["\"spring\"", "summer, winter"]);
    }
}
