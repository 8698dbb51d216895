//! A scene that is rendered, changed, and rendered again.

use super::prepare::Prepared;
use super::schedule::{self, Begun};
use super::{Observer, RenderError, RenderSettings, Rendering, Saved};
use crate::scene::coincident::{self, Coincident};
use crate::scene::validate::clean;
use crate::scene::{Camera, Diagnostics, Environment, Light, Material, Mesh, Scene};
use crate::world::Stale;
use glam::DAffine3;
use std::borrow::Cow;
use std::time::Instant;

/// A change of a scene. Numbers are those of the scene's lists.
#[derive(Clone, Debug)]
pub enum Edit {
    /// A camera moves or changes.
    Camera {
        /// Which.
        number: usize,
        /// What it is now.
        camera: Camera,
    },
    /// An instance moves.
    Transform {
        /// Which.
        instance: usize,
        /// Where it is now.
        world_from_object: DAffine3,
    },
    /// A material changes.
    Material {
        /// Which.
        number: usize,
        /// What it is now.
        material: Box<Material>,
    },
    /// A light changes.
    Light {
        /// Which.
        number: usize,
        /// What it is now.
        light: Box<Light>,
    },
    /// The light from all around changes.
    Environment(Option<Environment>),
    /// A mesh changes.
    Mesh {
        /// Which.
        number: usize,
        /// What it is now.
        mesh: Box<Mesh>,
    },
}

/// Why an edit was not made. The scene is as it was.
#[derive(Debug, thiserror::Error)]
pub enum EditError {
    /// There is no such thing in the scene.
    #[error("the scene has no {what} {number}: it has {count}")]
    Absent {
        /// "camera", "light" …
        what: &'static str,
        /// The number that was asked for.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// It could not be rendered.
    #[error("the {what} cannot be rendered: {why}")]
    Unfit {
        /// "light", "mesh" …
        what: &'static str,
        /// The reason.
        why: String,
    },
}

/// A scene with its settings, made ready for rays. Edits make anew only what they touch, when the next picture is rendered:
/// after a moved camera that is the view alone, until the camera is so far from where it began that positions would be
/// rounded too coarsely for it.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use sundog::scene::{Camera, Environment};
/// use sundog::{Edit, Scene, Session, Settings};
///
/// let camera = Camera::perspective(DAffine3::IDENTITY, 0.8);
/// let mut session = Session::owning(
///     Scene {
///         cameras: vec![camera.clone()],
///         environment: Some(Environment::constant([0.5; 3])),
///         ..Scene::default()
///     },
///     Settings { width: 8, height: 4, samples: 1, ..Settings::default() },
/// );
/// let picture = session.render(&sundog::render::Silent)?.picture;
/// assert_eq!(picture.layers[0].data[0], 0.5);
///
/// let moved = DAffine3::from_translation(DVec3::X);
/// session.apply(Edit::Camera { number: 0, camera: Camera { world_from_camera: moved, ..camera } })?;
/// session.apply(Edit::Environment(Some(Environment::constant([0.25; 3]))))?;
/// let picture = session.render(&sundog::render::Silent)?.picture;
/// assert_eq!(picture.layers[0].data[0], 0.25);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Session<'a> {
    scene: Cow<'a, Scene>,
    settings: RenderSettings,
    prepared: Option<Prepared>,
    stale: Stale,
    /// What coincides in the scene as it is now, once it has been looked for.
    coincident: Option<Coincident>,
}

impl<'a> Session<'a> {
    /// A session about a scene; the scene is copied when it is first edited.
    pub fn new(scene: &'a Scene, settings: RenderSettings) -> Self {
        Self {
            scene: Cow::Borrowed(scene),
            settings,
            prepared: None,
            stale: Stale::NONE,
            coincident: None,
        }
    }

    /// A session that owns its scene.
    pub fn owning(scene: Scene, settings: RenderSettings) -> Session<'static> {
        Session {
            scene: Cow::Owned(scene),
            settings,
            prepared: None,
            stale: Stale::NONE,
            coincident: None,
        }
    }

    /// The same, for who has looked already for what coincides in its scene.
    #[must_use]
    pub fn with_coincident(self, coincident: Coincident) -> Self {
        Self {
            coincident: Some(coincident),
            ..self
        }
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The settings.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
    }

    /// Takes other settings for the pictures to come.
    pub fn set_settings(&mut self, settings: RenderSettings) {
        self.settings = settings;
    }

    /// Changes the scene.
    ///
    /// # Errors
    /// The scene has no such thing, or what it would become cannot be rendered.
    pub fn apply(&mut self, edit: Edit) -> Result<(), EditError> {
        match edit {
            Edit::Camera { number, camera } => {
                let finite = camera.world_from_camera.is_finite();
                fit("camera", finite, "its place is not finite")?;
                let scene = self.scene.to_mut();
                *entry(&mut scene.cameras, "camera", number)? = camera;
            }
            Edit::Transform {
                instance,
                world_from_object,
            } => {
                let volume = world_from_object.matrix3.determinant();
                let sane = world_from_object.is_finite() && volume != 0.0;
                fit("instance", sane, "its transform is flat or not finite")?;
                let scene = self.scene.to_mut();
                entry(&mut scene.instances, "instance", instance)?.world_from_object =
                    world_from_object;
                self.stale.geometry = true;
            }
            Edit::Material { number, material } => {
                let alone = Scene {
                    materials: vec![*material],
                    ..self.materials_ground()
                };
                let material = cleaned(alone).materials.pop();
                let scene = self.scene.to_mut();
                let place = entry(&mut scene.materials, "material", number)?;
                *place = material.ok_or_else(|| unfit("material"))?;
                self.stale.materials = true;
            }
            Edit::Light { number, light } => {
                let alone = Scene {
                    lights: vec![*light],
                    ..Scene::default()
                };
                let light = cleaned(alone).lights.pop();
                let scene = self.scene.to_mut();
                let place = entry(&mut scene.lights, "light", number)?;
                *place = light.ok_or_else(|| unfit("light"))?;
                self.stale.lights = true;
            }
            Edit::Environment(environment) => {
                if let Some(Environment {
                    image: Some(image), ..
                }) = &environment
                {
                    let (number, count) = (image.0 as usize, self.scene.images.len());
                    if number >= count {
                        let what = "image";
                        return Err(EditError::Absent {
                            what,
                            number,
                            count,
                        });
                    }
                }
                self.scene.to_mut().environment = environment;
                self.stale.lights = true;
            }
            Edit::Mesh { number, mesh } => {
                let scene = self.scene.to_mut();
                let place = entry(&mut scene.meshes, "mesh", number)?;
                let material = mesh.material;
                let alone = Scene {
                    meshes: vec![Mesh {
                        material: None,
                        ..*mesh
                    }],
                    ..Scene::default()
                };
                let mesh = cleaned(alone).meshes.pop();
                *place = mesh.ok_or_else(|| unfit("mesh"))?;
                place.material = material.filter(|m| (m.0 as usize) < scene.materials.len());
                self.stale.geometry = true;
                // Its colours may be transparent.
                self.stale.materials = true;
            }
        }
        Ok(())
    }

    /// What a material refers to: the images, without their texels.
    fn materials_ground(&self) -> Scene {
        Scene {
            images: self.scene.images.clone(),
            ..Scene::default()
        }
    }

    /// Renders the scene as it is now.
    ///
    /// # Errors
    /// As [`super::render`].
    pub fn render(&mut self, observer: &dyn Observer) -> Result<Rendering, RenderError> {
        self.resume(None, observer)
    }

    /// Goes on with a render that was broken off.
    ///
    /// # Errors
    /// As [`super::resume`].
    pub fn resume(
        &mut self,
        saved: Option<&Saved>,
        observer: &dyn Observer,
    ) -> Result<Rendering, RenderError> {
        let begun = Begun {
            at: Instant::now(),
            saved,
        };
        schedule::check_saved(&self.scene, &self.settings, saved)?;
        schedule::announce(&self.scene, observer);
        self.prepare()?;
        let Some(prepared) = &self.prepared else {
            return Err(RenderError::Setting("the scene is not prepared".into()));
        };
        schedule::run(prepared, &self.scene, &self.settings, &begun, observer)
    }

    /// Makes the world fit the scene and the settings. Tells what was made anew beside the view.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn prepare(&mut self) -> Result<Stale, RenderError> {
        let stale = std::mem::take(&mut self.stale);
        if stale.geometry || stale.lights {
            self.coincident = None;
        }
        let scene = &*self.scene;
        let looked_for = || coincident::find(scene);
        let scene = (scene, &*self.coincident.get_or_insert_with(looked_for));
        let (prepared, made) = match self.prepared.take() {
            Some(prepared) => prepared.renewed(scene, &self.settings, stale)?,
            None => (Prepared::new(scene, &self.settings)?, Stale::ALL),
        };
        self.prepared = Some(prepared);
        Ok(made)
    }
}

/// One of the things of a list.
fn entry<'l, T>(
    list: &'l mut [T],
    what: &'static str,
    number: usize,
) -> Result<&'l mut T, EditError> {
    let count = list.len();
    list.get_mut(number).ok_or(EditError::Absent {
        what,
        number,
        count,
    })
}

fn fit(what: &'static str, fits: bool, why: &str) -> Result<(), EditError> {
    if fits {
        return Ok(());
    }
    Err(EditError::Unfit {
        what,
        why: why.into(),
    })
}

fn unfit(what: &'static str) -> EditError {
    EditError::Unfit {
        what,
        why: "a number is out of range or not finite".into(),
    }
}

/// A scene with what has no meaning left out.
fn cleaned(mut scene: Scene) -> Scene {
    clean(&mut scene, &mut Diagnostics::default());
    scene
}
