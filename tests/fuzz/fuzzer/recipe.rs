//! Random scenes, as trees that [`super::build`] makes scenes of.

use super::rng::Rng;
use serde_json::{Value, json};

/// Draws a scene.
pub fn draw(rng: &mut Rng) -> Value {
    let furnace = rng.chance(0.25);
    let things: Vec<Value> = (0..1 + rng.below(4)).map(|_| thing(rng, furnace)).collect();
    let lights: Vec<Value> = (0..rng.below(4)).map(|_| light(rng)).collect();
    let mut recipe = json!({
        "things": things,
        "camera": camera(rng),
        "seed": rng.below(1000),
        "samples": 1 + rng.below(8),
        "bounces": rng.pick(&[0, 1, 3, 8, 8, 30]),
    });
    if furnace {
        recipe["furnace"] = json!(true);
    } else {
        recipe["lights"] = json!(lights);
        if rng.chance(0.6) {
            recipe["environment"] = environment(rng);
        }
    }
    if rng.chance(0.4) {
        recipe["scale"] = json!(rng.pick(&[1e-6, 1e-3, 0.7, 1e3, 1e6]));
    }
    if rng.chance(0.3) {
        let far = rng.pick(&[1.0, 1e3, 1e5, 1e7]);
        recipe["center"] = json!([far, -far, 0.3 * far]);
    }
    if rng.chance(0.4) {
        recipe["settings"] = settings(rng);
    }
    // In a furnace too: what is mended must not shine.
    if rng.chance(0.15) {
        let broken = rng.pick(&["NaN", "inf", "-inf", "-1", "0", "1e-45"]);
        break_one(&mut recipe, rng, broken);
    }
    // Drawn last: what came before is what it ever was.
    if rng.chance(0.25) {
        recipe["links"] = json!(rng.below(1 << 16));
    }
    if rng.chance(0.15) {
        recipe["still"] = json!(true);
    }
    if rng.chance(0.15) {
        recipe["centre_passes"] = json!(true);
    }
    if !furnace && rng.chance(0.15) {
        recipe["catchers"] = json!(rng.below(1 << 16));
    }
    if rng.chance(0.2) {
        recipe["panorama"] = json!(rng.below(6));
        if rng.chance(0.3) {
            recipe["eye"] = json!(rng.pick(&[-0.1, 0.5, 1e6]));
        }
    }
    if !furnace && rng.chance(0.2) {
        recipe["portals"] = json!(rng.below(1 << 16));
    }
    if rng.chance(0.2) {
        recipe["aovs"] = json!(rng.below(1 << 16));
    }
    // Links of what moves and of faces in the same place, which are rare together.
    if recipe["links"].is_u64() && rng.chance(0.4) {
        let shapes = ["twins", "sheets", "box", "sphere"];
        for thing in recipe["things"].as_array_mut().into_iter().flatten() {
            thing["shape"] = json!(rng.pick(&shapes));
            thing[rng.pick(&["motion", "deformation"])] = json!(rng.below(1 << 16));
        }
    }
    recipe
}

fn thing(rng: &mut Rng, furnace: bool) -> Value {
    let shape = rng.pick(&[
        "sphere", "sphere", "quad", "sliver", "box", "twins", "sheets",
    ]);
    let places: Vec<Value> = (0..1 + rng.below(3)).map(|_| placement(rng)).collect();
    let mut thing = json!({
        "shape": shape,
        "rings": 2 + rng.below(12),
        "bumps": rng.pick(&[0.0, 0.0, 0.3, 1.0, 3.0]),
        "smooth": rng.chance(0.6),
        "places": places,
        "material": material(rng, furnace),
    });
    if rng.chance(0.15) {
        thing["colors"] = json!(rng.below(1 << 16));
    }
    if rng.chance(0.15) {
        thing["visibility"] = json!(rng.below(64));
    }
    if rng.chance(0.05) {
        thing["holdout"] = json!(true);
    }
    for motion in ["motion", "deformation"] {
        if rng.chance(0.1) {
            thing[motion] = json!(rng.below(1 << 16));
        }
    }
    thing
}

fn placement(rng: &mut Rng) -> Value {
    let size = rng.size();
    let mut place = json!({ "at": rng.place(), "turn": rng.turn() });
    place["scale"] = match rng.below(6) {
        0 => json!([size, rng.size(), rng.size()]),
        1 => json!([-0.7, 0.7, 0.7]),
        2 => json!([size, size, size]),
        _ => json!([0.8, 0.8, 0.8]),
    };
    place
}

fn material(rng: &mut Rng, furnace: bool) -> Value {
    let mut material = json!({
        "color": rng.color(),
        "metallic": rng.pick(&[0.0, 0.0, 1.0, 0.5, 1e-7]),
        "roughness": rng.share(),
    });
    if rng.chance(0.5) {
        material["ior"] = rng.ior();
        // Each path is of one colour then: no furnace is even.
        if !furnace && rng.chance(0.2) {
            material["dispersion"] = json!(rng.pick(&[0.1, 1.0, 5.0]));
        }
    }
    if rng.chance(0.3) {
        material["specular"] = rng.specular();
        material["specular_color"] = rng.color();
    }
    if rng.chance(0.4) {
        material["transmission"] = rng.share();
        material["thin"] = json!(rng.chance(0.4));
    }
    if rng.chance(0.25) {
        material["alpha"] = rng.share();
        material["alpha_mode"] = json!(rng.pick(&["blend", "mask"]));
    }
    if !furnace && rng.chance(0.2) {
        material["emission"] = rng.strength();
    }
    if !furnace && rng.chance(0.05) {
        material["unlit"] = json!(true);
    }
    if rng.chance(0.2) {
        material["double_sided"] = json!(true);
    }
    for texture in [
        "color",
        "metallic_roughness",
        "specular",
        "specular_color",
        "transmission",
    ] {
        if rng.chance(0.08) {
            material[format!("{texture}_texture")] = json!(rng.below(1 << 16));
        }
    }
    if rng.chance(0.15) {
        material["normal_texture"] = json!(rng.below(1 << 16));
        material["normal_scale"] = json!(rng.pick(&[1.0, 0.1, 5.0, 1e6, -1.0]));
    }
    material
}

fn light(rng: &mut Rng) -> Value {
    let mut light = json!({
        "kind": rng.pick(&["point", "point", "spot", "sun", "area"]),
        "strength": rng.strength(),
        "color": rng.color(),
        "at": rng.place(),
        "turn": rng.turn(),
        "radius": rng.pick(&[0.0, 1e-6, 0.05, 0.5, 1e3]),
    });
    match light["kind"].as_str() {
        Some("spot") => {
            light["angle"] = rng.angle(90.0);
            light["blend"] = rng.share();
        }
        Some("sun") => light["angle"] = rng.angle(180.0),
        Some("area") => {
            light["size"] = json!([rng.size(), rng.size()]);
            light["ellipse"] = json!(rng.chance(0.4));
            light["spread"] = rng.angle(180.0);
            light["normalize"] = json!(rng.chance(0.7));
        }
        _ => light["soft"] = json!(rng.chance(0.4)),
    }
    if rng.chance(0.15) {
        light["visibility"] = json!(rng.below(64));
        light["max_bounces"] = json!(rng.below(4));
    }
    light
}

fn environment(rng: &mut Rng) -> Value {
    let mut environment = json!({ "strength": rng.strength() });
    if rng.chance(0.6) {
        let size = rng.pick(&[[1, 1], [2, 1], [16, 8], [7, 5], [64, 1]]);
        environment["size"] = json!(size);
        environment["image"] = json!(rng.below(1 << 16));
        environment["spike"] = json!(rng.pick(&[0.0, 1.0, 1e8, 1e-30]));
    }
    environment
}

fn camera(rng: &mut Rng) -> Value {
    let mut camera = json!({
        "at": [0, 0.2, rng.pick(&[4.0, 4.0, 2.0, 0.0, 1e-3])],
        "kind": rng.pick(&["perspective", "perspective", "perspective", "orthographic", "panorama"]),
        "fov": rng.pick(&[40.0, 60.0, 1e-3, 179.9]),
    });
    if rng.chance(0.2) {
        camera["aperture"] = json!(rng.pick(&[1e-6, 0.05, 1.0, 1e3]));
        camera["focus"] = json!(rng.pick(&[1e-6, 1.0, 4.0, 1e20]));
        camera["blades"] = json!(rng.pick(&[0, 3, 6]));
    }
    if rng.chance(0.2) {
        camera["near"] = json!(rng.pick(&[0.0, 1e-6, 1.0, 3.5]));
        camera["far"] = json!(rng.pick(&[1e-3, 4.0, 1e30]));
    }
    camera
}

fn settings(rng: &mut Rng) -> Value {
    json!({
        "clamp_direct": rng.pick(&[0.0, 0.0, 1e-3, 10.0]),
        "clamp_indirect": rng.pick(&[0.0, 0.0, 1e-3, 10.0]),
        "filter_glossy": rng.pick(&[0.0, 0.0, 1.0, 1e6]),
        "light_sampling": rng.pick(&["mis", "mis", "nee", "bsdf"]),
        "light_samples": rng.pick(&[1, 1, 3]),
        "roulette": rng.pick(&[2, 1, 0]),
        "transparent_limit": rng.pick(&[-1, -1, 0, 2]),
        "glossy_limit": rng.pick(&[-1, -1, 0, 2]),
        "cull": rng.chance(0.2),
        "transparent_film": rng.chance(0.2),
        "transparent_glass": rng.chance(0.2),
    })
}

/// Puts a word in the place of a number.
fn break_one(recipe: &mut Value, rng: &mut Rng, word: &str) {
    let mut places = Vec::new();
    numbers(recipe, &mut Vec::new(), &mut places);
    if places.is_empty() {
        return;
    }
    let place = &places[rng.below(places.len())];
    let pointer: String = place.iter().map(|key| format!("/{key}")).collect();
    if let Some(number) = recipe.pointer_mut(&pointer) {
        *number = json!(word);
    }
}

/// Paths to all numbers of a tree.
pub fn numbers(value: &Value, at: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    match value {
        Value::Number(_) => found.push(at.clone()),
        Value::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                at.push(i.to_string());
                numbers(item, at, found);
                at.pop();
            }
        }
        Value::Object(map) => {
            for (key, item) in map {
                at.push(key.clone());
                numbers(item, at, found);
                at.pop();
            }
        }
        _ => {}
    }
}
