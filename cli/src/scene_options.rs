//! Options for reading a file, and for the camera, the light and the ground around it.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::{DVec3, Vec3};
use lighting::scene::load::{LoadOptions, UpAxis};
use lighting::scene::{Camera, Light, PointLight, Scene};

use crate::failure::Failure;
use crate::parse::{self, Viewpoint};

/// How a file is read.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Files")]
pub(crate) struct FileOptions {
    /// Leave out the parts of a glTF file that cannot be read, with a note, even if geometry is
    /// missing then
    #[arg(long)]
    pub(crate) lenient: bool,

    /// A folder from which a file may also take buffers, images and materials, subfolders
    /// included [default: only the file's own folder]
    #[arg(long, value_name = "DIR")]
    pub(crate) assets: Option<PathBuf>,

    /// Unit of length in a PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB file: mm, cm, m, km, in, ft or a
    /// number of metres [default: m]
    #[arg(long, value_name = "UNIT", value_parser = parse::unit, allow_negative_numbers = true)]
    pub(crate) unit: Option<f64>,

    /// The axis that points up in a PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB file [default: y]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub(crate) up: Option<Up>,
}

/// Axes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Up {
    /// Rare
    X,
    /// glTF, and most programs for pictures
    Y,
    /// Most programs for plans and scans
    Z,
}

impl FileOptions {
    /// The first option that is given, as it is written.
    pub(crate) fn first_given(&self) -> Option<&'static str> {
        let given = [
            (self.lenient, "--lenient"),
            (self.assets.is_some(), "--assets"),
            (self.unit.is_some(), "--unit"),
            (self.up.is_some(), "--up"),
        ];
        given
            .iter()
            .find(|(is_given, _)| *is_given)
            .map(|(_, name)| *name)
    }

    /// The options for the reader of a file.
    pub(crate) fn for_file(&self) -> LoadOptions {
        LoadOptions {
            lenient: self.lenient,
            assets: self.assets.clone(),
            unit: self.unit.unwrap_or(1.0),
            up: match self.up {
                Some(Up::X) => UpAxis::X,
                Some(Up::Z) => UpAxis::Z,
                Some(Up::Y) | None => UpAxis::Y,
            },
        }
    }
}

/// The camera, the light and the ground around the contents of a file.
#[derive(Debug, Clone, Copy, Default, Args)]
#[command(next_help_heading = "Camera, light, ground")]
pub(crate) struct Surroundings {
    /// Position of the camera, the point in the middle of its picture, both in metres with +Y
    /// up, and optionally its vertical field of view in degrees (otherwise 45)
    #[arg(long, value_name = "X,Y,Z,X,Y,Z[,DEGREES]", value_parser = parse::viewpoint, allow_hyphen_values = true)]
    pub(crate) camera: Option<Viewpoint>,

    /// A white point light at this position, in metres with +Y up, instead of the scene's
    /// lights
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true)]
    pub(crate) light_at: Option<DVec3>,

    /// Put no ground under a file that has no light, camera or floor
    #[arg(long)]
    pub(crate) no_ground: bool,
}

impl Surroundings {
    /// Places the camera and the light that were asked for in a scene that was moved by
    /// `offset` when it was read.
    pub(crate) fn place(&self, scene: &mut Scene, offset: DVec3) -> Result<(), Failure> {
        let placed = |point: DVec3| (point - offset).as_vec3();
        if let Some(camera) = self.camera {
            const DEGREES: f64 = 45.0;
            let fov = camera.degrees.unwrap_or(DEGREES).to_radians() as f32;
            let camera = Camera::look_at(placed(camera.eye), placed(camera.target), fov);
            let camera = camera.map_err(|error| Failure::from(error).about("--camera"))?;
            scene.camera = Some(camera);
        }
        if let Some(position) = self.light_at {
            scene.lights = vec![Light::Point(PointLight {
                position: placed(position),
                ..PointLight::default()
            })];
        }
        Ok(())
    }

    /// Gives the light that was asked for the brightness that a default light would have at its
    /// place, now that the centre of the scene is known.
    pub(crate) fn brighten(&self, scene: &mut Scene, centre: Vec3) {
        if let (Some(_), [Light::Point(light)]) = (self.light_at, &mut scene.lights[..]) {
            light.intensity = Scene::placed_intensity(light.position.distance(centre));
        }
    }
}
