//! Random scenes, as trees that [`super::build`] makes scenes of.

use super::dice::Dice;
use serde_json::{Value, json};

/// Draws a scene.
pub fn draw(dice: &mut Dice) -> Value {
    let furnace = dice.chance(0.25);
    let things: Vec<Value> = (0..1 + dice.below(4))
        .map(|_| thing(dice, furnace))
        .collect();
    let lights: Vec<Value> = (0..dice.below(4)).map(|_| light(dice)).collect();
    let mut recipe = json!({
        "things": things,
        "camera": camera(dice),
        "seed": dice.below(1000),
        "samples": 1 + dice.below(8),
        "bounces": dice.pick(&[0, 1, 3, 8, 8, 30]),
    });
    if furnace {
        recipe["furnace"] = json!(true);
    } else {
        recipe["lights"] = json!(lights);
        if dice.chance(0.6) {
            recipe["environment"] = environment(dice);
        }
    }
    if dice.chance(0.4) {
        recipe["scale"] = json!(dice.pick(&[1e-6, 1e-3, 0.7, 1e3, 1e6]));
    }
    if dice.chance(0.3) {
        let far = dice.pick(&[1.0, 1e3, 1e5, 1e7]);
        recipe["center"] = json!([far, -far, 0.3 * far]);
    }
    if dice.chance(0.4) {
        recipe["settings"] = settings(dice);
    }
    // In a furnace too: what is mended must not shine.
    if dice.chance(0.15) {
        let broken = dice.pick(&["NaN", "inf", "-inf", "-1", "0", "1e-45"]);
        break_one(&mut recipe, dice, broken);
    }
    recipe
}

fn thing(dice: &mut Dice, furnace: bool) -> Value {
    let shape = dice.pick(&[
        "sphere", "sphere", "quad", "sliver", "box", "twins", "sheets",
    ]);
    let places: Vec<Value> = (0..1 + dice.below(3)).map(|_| placement(dice)).collect();
    let mut thing = json!({
        "shape": shape,
        "rings": 2 + dice.below(12),
        "bumps": dice.pick(&[0.0, 0.0, 0.3, 1.0, 3.0]),
        "smooth": dice.chance(0.6),
        "places": places,
        "material": material(dice, furnace),
    });
    if dice.chance(0.15) {
        thing["colors"] = json!(dice.below(1 << 16));
    }
    if dice.chance(0.15) {
        thing["visibility"] = json!(dice.below(64));
    }
    if dice.chance(0.05) {
        thing["holdout"] = json!(true);
    }
    thing
}

fn placement(dice: &mut Dice) -> Value {
    let size = dice.size();
    let mut place = json!({ "at": dice.place(), "turn": dice.turn() });
    place["scale"] = match dice.below(6) {
        0 => json!([size, dice.size(), dice.size()]),
        1 => json!([-0.7, 0.7, 0.7]),
        2 => json!([size, size, size]),
        _ => json!([0.8, 0.8, 0.8]),
    };
    place
}

fn material(dice: &mut Dice, furnace: bool) -> Value {
    let mut material = json!({
        "color": dice.color(),
        "metallic": dice.pick(&[0.0, 0.0, 1.0, 0.5, 1e-7]),
        "roughness": dice.share(),
    });
    if dice.chance(0.5) {
        material["ior"] = dice.ior();
    }
    if dice.chance(0.3) {
        material["specular"] = dice.specular();
        material["specular_color"] = dice.color();
    }
    if dice.chance(0.4) {
        material["transmission"] = dice.share();
        material["thin"] = json!(dice.chance(0.4));
    }
    if dice.chance(0.25) {
        material["alpha"] = dice.share();
        material["alpha_mode"] = json!(dice.pick(&["blend", "mask"]));
    }
    if !furnace && dice.chance(0.2) {
        material["emission"] = dice.strength();
    }
    if !furnace && dice.chance(0.05) {
        material["unlit"] = json!(true);
    }
    if dice.chance(0.2) {
        material["double_sided"] = json!(true);
    }
    for texture in [
        "color",
        "metallic_roughness",
        "specular",
        "specular_color",
        "transmission",
    ] {
        if dice.chance(0.08) {
            material[format!("{texture}_texture")] = json!(dice.below(1 << 16));
        }
    }
    if dice.chance(0.15) {
        material["normal_texture"] = json!(dice.below(1 << 16));
        material["normal_scale"] = json!(dice.pick(&[1.0, 0.1, 5.0, 1e6, -1.0]));
    }
    material
}

fn light(dice: &mut Dice) -> Value {
    let mut light = json!({
        "kind": dice.pick(&["point", "point", "spot", "sun", "area"]),
        "strength": dice.strength(),
        "color": dice.color(),
        "at": dice.place(),
        "turn": dice.turn(),
        "radius": dice.pick(&[0.0, 1e-6, 0.05, 0.5, 1e3]),
    });
    match light["kind"].as_str() {
        Some("spot") => {
            light["angle"] = dice.angle(90.0);
            light["blend"] = dice.share();
        }
        Some("sun") => light["angle"] = dice.angle(180.0),
        Some("area") => {
            light["size"] = json!([dice.size(), dice.size()]);
            light["ellipse"] = json!(dice.chance(0.4));
            light["spread"] = dice.angle(180.0);
            light["normalize"] = json!(dice.chance(0.7));
        }
        _ => light["soft"] = json!(dice.chance(0.4)),
    }
    if dice.chance(0.15) {
        light["visibility"] = json!(dice.below(64));
        light["max_bounces"] = json!(dice.below(4));
    }
    light
}

fn environment(dice: &mut Dice) -> Value {
    let mut environment = json!({ "strength": dice.strength() });
    if dice.chance(0.6) {
        let size = dice.pick(&[[1, 1], [2, 1], [16, 8], [7, 5], [64, 1]]);
        environment["size"] = json!(size);
        environment["image"] = json!(dice.below(1 << 16));
        environment["spike"] = json!(dice.pick(&[0.0, 1.0, 1e8, 1e-30]));
    }
    environment
}

fn camera(dice: &mut Dice) -> Value {
    let mut camera = json!({
        "at": [0, 0.2, dice.pick(&[4.0, 4.0, 2.0, 0.0, 1e-3])],
        "kind": dice.pick(&["perspective", "perspective", "perspective", "orthographic", "panorama"]),
        "fov": dice.pick(&[40.0, 60.0, 1e-3, 179.9]),
    });
    if dice.chance(0.2) {
        camera["aperture"] = json!(dice.pick(&[1e-6, 0.05, 1.0, 1e3]));
        camera["focus"] = json!(dice.pick(&[1e-6, 1.0, 4.0, 1e20]));
        camera["blades"] = json!(dice.pick(&[0, 3, 6]));
    }
    if dice.chance(0.2) {
        camera["near"] = json!(dice.pick(&[0.0, 1e-6, 1.0, 3.5]));
        camera["far"] = json!(dice.pick(&[1e-3, 4.0, 1e30]));
    }
    camera
}

fn settings(dice: &mut Dice) -> Value {
    json!({
        "clamp_direct": dice.pick(&[0.0, 0.0, 1e-3, 10.0]),
        "clamp_indirect": dice.pick(&[0.0, 0.0, 1e-3, 10.0]),
        "filter_glossy": dice.pick(&[0.0, 0.0, 1.0, 1e6]),
        "light_sampling": dice.pick(&["mis", "mis", "nee", "bsdf"]),
        "light_samples": dice.pick(&[1, 1, 3]),
        "roulette": dice.pick(&[2, 1, 0]),
        "transparent_limit": dice.pick(&[-1, -1, 0, 2]),
        "glossy_limit": dice.pick(&[-1, -1, 0, 2]),
        "cull": dice.chance(0.2),
        "transparent_film": dice.chance(0.2),
    })
}

/// Puts a word in the place of a number.
fn break_one(recipe: &mut Value, dice: &mut Dice, word: &str) {
    let mut places = Vec::new();
    numbers(recipe, &mut Vec::new(), &mut places);
    if places.is_empty() {
        return;
    }
    let place = &places[dice.below(places.len())];
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
