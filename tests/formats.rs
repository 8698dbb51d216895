//! Files in, scenes out: what glTF and image files become, and that no bytes whatever make the
//! program panic, hang or eat memory.

mod animation;
mod blender;
mod broken;
mod compressed;
mod extensions;
mod features;
mod foreign;
mod hostile;
mod images;
mod khr_materials;
mod kit;
mod sundog;
mod usd;
mod usd_lights;
mod usd_materials;
mod usd_shapes;
