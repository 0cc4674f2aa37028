//! Light that surfaces receive by way of the fog, and an environment, as the command line
//! asks for them.

use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers};
use gpu_backend::Cpu;
use gpu_backend::gpu::Gpu;
use lighting::environment::{AddEnvironment, Ambient, Environment, EnvironmentError};
use lighting::indirect::{self, FogShadows, Indirect, IndirectError, IndirectLight, LitView};
use lighting::scene::PhaseFunction;
use lighting::scene::view::View;

use crate::args::{AmbientOption, IndirectOptions, SurfaceScattering};
use crate::devices::Device;
use crate::failure::Failure;
use crate::file;
use crate::format::count;
use crate::input::Input;
use crate::parse;

/// Nodes of the quadrature, which is within 1 % of the brightest surface without
/// shadows.
const NODES: u32 = 8;

/// Rays per surface that find out how much of the environment it sees.
const OPENNESS_RAYS: u32 = 32;

/// The light that the options add to a view, one RGB0 per pixel; `None` if they ask for
/// none. Says in the input's notes how.
pub(crate) fn radiance(
    options: &IndirectOptions,
    map: u32,
    device: &Device,
    input: &mut Input,
    view: &View,
) -> Result<Option<Vec<[f32; 4]>>, Failure> {
    let environment = options.environment.as_deref().map(read).transpose()?;
    let environment = match (environment, options.environment_distance) {
        (Some(environment), Some(distance)) => Some(
            environment
                .at_distance(distance)
                .map_err(|error| Failure::from(error).about("--environment-distance"))?,
        ),
        (environment, _) => environment,
    };
    let ambient = options.ambient.ambient;
    if environment.is_none() && options.surface_scattering.is_none() && ambient.is_none() {
        return Ok(None);
    }
    check_ambient(&options.ambient, input)?;
    if options.surface_scattering.is_some() && input.scene.medium.is_none() {
        return Err(Failure::new(
            "--surface-scattering needs fog, and the scene has none",
        ));
    }
    let light = IndirectLight {
        scattering: options.surface_scattering.map(|way| match way {
            SurfaceScattering::Unshadowed => FogShadows::None,
            SurfaceScattering::Shadowed => FogShadows::Maps { resolution: map },
        }),
        nodes: NODES,
        environment: environment.as_ref(),
        ambient: ambient.map(|radiance| radiance.to_array()),
        openness_rays: OPENNESS_RAYS,
    };
    let lit = LitView {
        view,
        scene: &input.scene,
        geometry: &input.geometry,
        tracer: &input.tracer,
        emitters: &input.emitters,
        medium: input.scene.medium.as_ref(),
    };
    let cpu = Cpu::new();
    let result = match &device.context {
        None => indirect::radiance(&cpu, &cpu, lit, light),
        Some(context) => indirect::radiance(&Gpu::new(context.clone()), &cpu, lit, light),
    };
    let indirect = result.map_err(named)?;
    input
        .notes
        .extend(notes(&indirect, environment.is_some(), input));
    Ok(Some(indirect.radiance))
}

/// Refuses an ambient light that is not one, or for which there is no fog.
pub(crate) fn check_ambient(option: &AmbientOption, input: &Input) -> Result<(), Failure> {
    match (option.ambient, &input.scene.medium) {
        (None, _) => Ok(()),
        (Some(_), None) => Err(Failure::new("--ambient needs fog, and the scene has none")),
        (Some(radiance), Some(medium)) => Ambient::new(radiance.to_array(), medium)
            .map(|_| ())
            .map_err(|error| Failure::from(error).about("--ambient")),
    }
}

/// The ambient light that the fog in front of everything scatters into the eye, one RGB0 per
/// pixel; `None` if none is asked for.
pub(crate) fn ambient(
    option: &AmbientOption,
    input: &Input,
    view: &View,
) -> Result<Option<Vec<[f32; 4]>>, Failure> {
    check_ambient(option, input)?;
    let (Some(radiance), Some(medium)) = (option.ambient, &input.scene.medium) else {
        return Ok(None);
    };
    let ambient = Ambient::new(radiance.to_array(), medium)?;
    let mut sum = vec![[0.0; 4]; view.rays().len()];
    Cpu::new().add_ambient(&view.rays().to_vec(), &ambient, &mut sum)?;
    Ok(Some(sum))
}

/// An error with the option that can set it right.
fn named(error: IndirectError) -> Failure {
    let option = match &error {
        IndirectError::Environment(
            EnvironmentError::NoDistance | EnvironmentError::UnusedDistance,
        ) => "--environment-distance",
        IndirectError::Environment(EnvironmentError::Ambient { .. }) => "--ambient",
        IndirectError::Environment(_) => "--environment",
        IndirectError::ShadowMap(_) => "--map",
        _ => "--surface-scattering",
    };
    Failure::from(error).about(option)
}

/// Notes for the reader of the output.
fn notes(indirect: &Indirect, environment: bool, input: &Input) -> Vec<String> {
    let mut notes = Vec::new();
    if indirect.in_closed_form + indirect.by_quadrature > 0 {
        notes.push(format!(
            "light scattered onto surfaces: {} in closed form, {} by quadrature",
            count(indirect.in_closed_form, "light"),
            count(indirect.by_quadrature, "light"),
        ));
    }
    if let (true, Some(medium)) = (environment, &input.scene.medium) {
        if medium.phase() != PhaseFunction::Isotropic {
            notes.push("the halo of the environment is computed for isotropic scattering".into());
        }
        if medium.bounds().is_some() {
            notes.push(
                "the halo of the environment is computed for a ball of fog as deep as the box"
                    .into(),
            );
        }
    }
    notes
}

/// A colour, or a file.
fn read(text: &str) -> Result<Environment, Failure> {
    let about = |failure: Failure| failure.about("--environment");
    if let Ok(colour) = parse::coefficient(text) {
        return Environment::even(colour.to_array()).map_err(|error| about(error.into()));
    }
    let path = Path::new(text);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let (width, height, texels) = match extension.as_deref() {
        Some("exr") => exr_texels(path),
        Some("hdr" | "png" | "jpg" | "jpeg") => image_texels(path),
        _ => Err(Failure::new(format!(
            "{text} is neither a colour (one number, or R,G,B) nor the name of an .exr, .hdr, .png or .jpg file"
        ))),
    }
    .map_err(about)?;
    Environment::new(width, height, texels).map_err(|error| about(error.into()))
}

/// Environments have at most as many texels, which is 16384 × 8192.
const MAX_TEXELS: usize = 1 << 27;

fn bytes_of(path: &Path) -> Result<Vec<u8>, Failure> {
    file::read(path).map_err(|error| Failure::from(error).about(&path.display().to_string()))
}

/// Width, height and linear RGB.
type Texels = (usize, usize, Vec<[f32; 3]>);

fn exr_texels(path: &Path) -> Result<Texels, Failure> {
    let named = |error: exr::error::Error| Failure::from(error).about(&path.display().to_string());
    let file = bytes_of(path)?;
    let head = exr::meta::MetaData::read_from_buffered(&file[..], false).map_err(named)?;
    // Memory for all texels is taken before the first of them is read.
    let texels = head.headers.iter().map(|head| head.layer_size.area()).max();
    if texels.is_some_and(|texels| texels > MAX_TEXELS) {
        let message = format!("it has more than {MAX_TEXELS} pixels");
        return Err(Failure::new(message).about(&path.display().to_string()));
    }
    let read = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![[0.0_f32; 3]; size.area()]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| {
                texels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(file))
        .map_err(named)?;
    let size = read.layer_data.size;
    let (_, texels) = read.layer_data.channel_data.pixels;
    Ok((size.width(), size.height(), texels))
}

/// PNG and JPEG are taken as sRGB.
fn image_texels(path: &Path) -> Result<Texels, Failure> {
    let named = |failure: Failure| failure.about(&path.display().to_string());
    let mut reader = image::ImageReader::new(std::io::Cursor::new(bytes_of(path)?));
    // The name decides the format, unless the contents say otherwise.
    if let Ok(format) = image::ImageFormat::from_path(path) {
        reader.set_format(format);
    }
    let reader = reader
        .with_guessed_format()
        .map_err(|error| named(error.into()))?;
    let is_linear = reader.format() == Some(image::ImageFormat::Hdr);
    let picture = reader
        .decode()
        .map_err(|error| named(error.into()))?
        .into_rgb32f();
    let linear = |value: f32| match value {
        _ if is_linear => value,
        ..=0.04045 => value / 12.92,
        _ => ((value + 0.055) / 1.055).powf(2.4),
    };
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let texels = picture.pixels().map(|pixel| pixel.0.map(linear)).collect();
    Ok((width, height, texels))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texel(environment: &Environment) -> [f32; 3] {
        environment.texels()[0]
    }

    #[test]
    fn colours_are_one_number_or_three() {
        assert_eq!(texel(&read("0.25").unwrap()), [0.25; 3]);
        assert_eq!(texel(&read("1,2,3").unwrap()), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn files_are_read_as_linear_light() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        image::DynamicImage::ImageRgb8(image::RgbImage::from_pixel(
            4,
            2,
            image::Rgb([188, 255, 0]),
        ))
        .save(path("a.png"))
        .unwrap();
        let png = read(&path("a.png")).unwrap();
        assert_eq!((png.width(), png.height()), (4, 2));
        assert!((texel(&png)[0] - 0.503).abs() < 1e-3 && texel(&png)[1] == 1.0);

        let size = crate::parse::Size {
            width: 4,
            height: 2,
        };
        let radiance: Vec<[f32; 4]> = (0..8).map(|i| [i as f32, 30.0, 0.0, 0.0]).collect();
        let exr = crate::picture::Picture::new(size, &radiance).exr().unwrap();
        std::fs::write(path("b.exr"), exr).unwrap();
        let exr = read(&path("b.exr")).unwrap();
        assert_eq!(exr.texels()[5], [5.0, 30.0, 0.0]);
    }

    #[test]
    fn what_is_no_environment_is_named() {
        for (text, word) in [
            ("-1", "--environment"),
            ("sky.bmp", "sky.bmp"),
            ("no.exr", "no.exr"),
        ] {
            let message = read(text).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
