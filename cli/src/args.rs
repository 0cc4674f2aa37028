//! The command line.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use glam::Vec3;
use lighting::methods::Registry;
use lighting::precomputed::Form;
use lighting::scene::Bounds;
use shadow_dag::Share;

use crate::added::AddedOptions;
use crate::devices::{BackendName, PictureBackend};
use crate::parse::{self, Size, Square};
use crate::scene_options::{FileOptions, Surroundings};

const EXAMPLES: &str = "\
Examples:
  crepuscular compare
      Compare all methods on an embedded scene; the report is in crepuscular-report/.
  crepuscular compare street.glb --size 960x540 --time-budget 600 --out street-report
      The same on your scene, with more pixels and more time.
  crepuscular compare city --quick --plan
      Print what would run and what would not, and why.
  crepuscular plan city --error 1%
      Predict within seconds which method is the fastest within an error.
  crepuscular render city --visibility exact -o city.png
      Render one picture with exact shadows.
  crepuscular render street.glb --sigma-s 0.02,0.03,0.05 --phase hg --g 0.6 \\
      --visibility equi-angular --samples 64 -o street.exr
      Bluish haze that scatters forward, 64 equi-angular samples per ray.
  crepuscular bake city --resolution 16384 -o city.cpvs
      Precompute the shadows of a light; `inspect city.cpvs` describes the result.
  crepuscular bake street.glb --light all --texel 1cm -o street.cpvs
      Precompute the shadows of all lights, each at the resolution that its surfaces need.
  crepuscular render city --shadows city.cpvs -o city.png
      Render with these shadows, on surfaces and in the air.
  crepuscular render street.glb --smoke plume.vol@0,1,-4 --hair wig.hair@2,1.6,0,0.01 -o smoke.png
      Add smoke and hair to a scene.
  crepuscular stress --methods exact
      See how a method copes with extreme cases.

Scenes are glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB files, or names of embedded ones (`crepuscular scenes`). \
A scene without a camera, a light or a medium is given one, and a note says so. \
Lengths are metres, coefficients 1/m, light is linear RGB.

Results go to standard output; notes, progress and errors to standard error. The exit code is 0 for \
success; 1 if a comparison measured nothing, if no method is expected to meet an error or a time, or \
if a hard case shows a violation; 2 if something is wrong with what was asked for; and 128 plus the \
number of the signal if a signal ended the program, such as 130 after Ctrl-C. Files appear only when \
they are complete. A program that is killed (SIGKILL) can leave a file behind beside them whose name \
begins with .crepuscular-; it can be deleted. If a report was being replaced and its folder is \
missing, the earlier report is in .crepuscular-old-…";

/// Light and shadow in fog: which method, at which quality, is worth its time?
///
/// A picture of fog needs two answers for each eye ray: which parts of it see the light, and
/// how much light arrives from these parts. This program measures ways to answer them against a
/// converged reference, on your scene, and renders with any of them.
#[derive(Debug, Parser)]
#[command(name = "crepuscular", version, after_long_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,

    /// Print errors, warnings and the results asked for, but no notes, progress or summary
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
}

impl Arguments {
    /// Reads a command line. The methods that it may name are those of `methods`.
    pub(crate) fn read(
        methods: &Registry,
        arguments: impl IntoIterator<Item = OsString>,
    ) -> Result<Self, clap::Error> {
        let command = Self::command(methods);
        Self::from_arg_matches(&command.try_get_matches_from(arguments)?)
    }

    /// The definition of the whole command line.
    pub(crate) fn command(methods: &Registry) -> clap::Command {
        with_names(<Self as CommandFactory>::command(), methods)
    }
}

/// Adds the names of the visibility sources and of the evaluators as possible values.
fn with_names(command: clap::Command, methods: &Registry) -> clap::Command {
    let values = |halves: Vec<[&'static str; 2]>| {
        let value = |[name, title]: [&'static str; 2]| PossibleValue::new(name).help(title);
        PossibleValuesParser::new(halves.into_iter().map(value))
    };
    let visibilities = values(methods.visibilities());
    let evaluators = values(methods.evaluators());
    command.mut_subcommand("render", |render| {
        render
            .mut_arg("visibility", |arg| arg.value_parser(visibilities))
            .mut_arg("airlight", |arg| arg.value_parser(evaluators))
    })
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Compare(Compare),
    Plan(Plan),
    Render(Render),
    Bake(Bake),
    Merge(Merge),
    Inspect(Inspect),
    Methods(Methods),
    Scenes(Scenes),
    Stress(Stress),
    Completions(Completions),
    Man(Man),
}

/// Measure every method at every quality: error against run time
///
/// Runs every method that applies to the scene, at every quality setting, on every backend that
/// is present, and measures its time and its error against a converged reference. Writes a
/// folder with index.html, which needs only a browser, results.csv, and EXR files of the
/// reference, of the surfaces and of the airlight by each method. Returns 1 if nothing was
/// measured.
///
/// Besides the methods, studies measure one algorithm each: airlight.csv evaluators of
/// airlight; voxels.csv voxelized shadow volumes; area-lights.csv area lights made of many such
/// volumes; curves.csv transmittance curves; hair.csv hair that is lit through them;
/// precomputed-voxelized-shadows.csv precomputed voxelized shadows; shadowed-lights.csv such
/// shadows of all lights beside shadow maps; many-lights.csv up to 10,000 lamps in the air of
/// the scene; marching.csv marches between shadow volumes, on meshes of its own. Ctrl-C during
/// the studies ends them early and reports what was measured.
///
/// Errors are those of the airlight, in linear radiance, divided by the mean radiance of the
/// reference. Surfaces, and what --ambient adds, are the same for all methods and do not count.
/// Errors depend only on the scene, the size and the settings. When time is short, repetitions
/// are dropped first, then qualities between the lowest and the highest, then methods that are
/// neither a paper's nor the baseline; FLIP and the errors of shadow maps alone may be missing
/// too.
///
/// A glTF file can define its medium in the `extras` of its scene: {"medium": {"sigma_s": 0.02,
/// "sigma_a": [0, 0, 0.01], "phase": "henyey-greenstein", "g": 0.6, "box": [[-5, 0, -5], [5, 3,
/// 5]]}}; options on the command line take precedence.
///
/// While it is being written, the report is in a folder beside DIR whose name is DIR.tmp- and a
/// few letters. A run that is killed (SIGKILL) leaves this folder behind; it can be deleted.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// A glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB file, or the name of an embedded scene
    #[arg(default_value = "city")]
    pub(crate) scene: String,

    /// Folder of the report; an earlier report in it is replaced
    #[arg(short, long, value_name = "DIR", default_value = "crepuscular-report")]
    pub(crate) out: PathBuf,

    /// Largest size of the picture; it is reduced if the time budget requires it [default:
    /// 480x270, 160x90 with --quick]
    #[arg(long, value_name = "WxH", value_parser = parse::size, allow_hyphen_values = true)]
    pub(crate) size: Option<Size>,

    /// Seconds for everything, from start to report; the picture is halved once or twice if the
    /// scene has too many lights and triangles for this time, and as often as necessary if the
    /// reference alone would not fit [default: 150, 14 with --quick]
    #[arg(long, value_name = "SECONDS", value_parser = parse::duration, allow_negative_numbers = true)]
    pub(crate) time_budget: Option<f64>,

    /// Use a small picture and few qualities
    #[arg(long)]
    pub(crate) quick: bool,

    /// Measure everything at the requested size, however long it takes
    #[arg(long, conflicts_with = "time_budget")]
    pub(crate) fixed: bool,

    /// Measure only methods whose name contains one of these (see `crepuscular methods`)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,

    /// Carry out only these studies, named after their CSV files (voxels, hair), or "none"
    /// [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) studies: Vec<String>,

    /// Backends to measure [default: all that are present]
    ///
    /// A GPU must be present if it is requested here or if the environment variable REQUIRE_GPU
    /// is 1. If there are several, the environment variable CREPUSCULAR_ADAPTER selects one by
    /// a part of its name. With a software adapter the CPU emulates the GPU: its times are
    /// measured but do not represent a GPU, and the report says so.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) backend: Vec<BackendName>,

    /// Relative error allowed in a pixel of the reference; at least 2e-3 with area lights (1e-2
    /// with --quick), and at least 1e-3 where smoke or uneven fog is seen (5e-3 with --quick)
    #[arg(long, value_name = "SHARE", default_value = "1e-6", value_parser = parse::tolerance)]
    pub(crate) tolerance: f64,

    /// Also make a film with this many frames in each shot, to measure how much errors flicker
    /// while the camera or the lights move, and whether methods lag; film.csv has the results
    ///
    /// One shot moves by small steps, forth and back over the same places; another jumps
    /// between unrelated places. Pictures are at most 160x90, or with --fixed at most the size
    /// of the comparison's. A film takes half of the --time-budget; without one it adds 4
    /// seconds for each frame of each shot.
    #[arg(long, value_name = "FRAMES", value_parser = clap::value_parser!(u32).range(5..=600), allow_negative_numbers = true)]
    pub(crate) film: Option<u32>,

    /// What moves in the film
    #[arg(
        long,
        value_enum,
        value_name = "WHAT",
        default_value = "camera",
        requires = "film"
    )]
    pub(crate) film_path: FilmPath,

    /// Write the frames of the film into the report's folder as numbered PNG files, for
    /// programs that compare films
    ///
    /// They are called film-MOVED-STEPS-NAME-0000.png and so on, those of the reference
    /// film-MOVED-STEPS-reference-0000.png, and all have the same exposure. ColorVideoVDP
    /// (https://github.com/gfxdisp/ColorVideoVDP) estimates how much of the difference a viewer
    /// sees: cvvdp --test film-camera-small-NAME-%04d.png --ref
    /// film-camera-small-reference-%04d.png --fps 30 --display standard_fhd
    #[arg(long, requires = "film")]
    pub(crate) film_frames: bool,

    /// Let smoke cast shadows into even fog without being seen itself, and leave out fog that
    /// thins out with altitude; this compares the methods for shadows in even fog
    #[arg(long)]
    pub(crate) smoke_unseen: bool,

    /// Print what would run and what would not, with reasons, and stop
    #[arg(long)]
    pub(crate) plan: bool,

    /// Leave out every setting that another one is expected to beat by a factor of 2 in both
    /// time and error (see `crepuscular plan`)
    #[arg(long)]
    pub(crate) auto: bool,

    /// Print the summary as JSON: the run, the scene, all measurements, the slopes of the
    /// curves, and what was left out
    #[arg(long, conflicts_with = "plan")]
    pub(crate) json: bool,

    #[command(flatten)]
    pub(crate) ambient: AmbientOption,

    #[command(flatten)]
    pub(crate) options: SceneOptions,
}

/// What moves in a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FilmPath {
    /// The camera: in small steps of a third of a pixel, and in large ones
    Camera,
    /// All lights: in small steps of half a texel of their shadow maps, and in large ones
    Light,
    /// First the camera, then the lights
    Both,
}

/// Predict the time and the error of each method on a scene
///
/// Runs methods on a few thousand pixels and compares some of these pixels with the reference.
/// Prints which parts of the airlight are computed and which are left out, and for each method
/// at each quality: seconds before the first frame, seconds per frame, memory, and the error
/// with its standard error. Settings that are too expensive to try are predicted from other
/// qualities of the method, or listed without a prediction.
///
/// With --error or --time it also prints the choice that `render` makes with the same option.
/// The time is that of one of many frames, unless --frames says how many. If no setting meets
/// the target, the nearest one is printed and the exit code is 1.
///
/// A GPU has to be started: its device, and the shaders of a first frame. If every setting is
/// finished earlier without it, it is listed as left out, for --frames frames or for one, with
/// the number of frames from which it pays.
///
/// Errors are those of `compare` for the same picture, and do not depend on the clock. Times
/// are those of the machine in its current state.
///
/// --calibrate measures what the methods cost on this machine, in seconds per unit of counted
/// work, and writes it to a file: profile.json in the folder crepuscular of the user's cache,
/// or --profile FILE. From then on this file decides what is cheap enough to try.
#[derive(Debug, Args)]
#[command(after_long_help = PLAN_EXAMPLES)]
pub(crate) struct Plan {
    /// A glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB file, or the name of an embedded
    /// scene; with --calibrate any number of these [default with --calibrate: a few embedded scenes]
    #[arg(required_unless_present = "calibrate")]
    pub(crate) scene: Vec<String>,

    /// Choose the fastest method within this error: RMSE over the mean radiance, such as 1% or
    /// 0.01
    #[arg(long, value_name = "ERROR", value_parser = parse::error_target, allow_hyphen_values = true)]
    pub(crate) error: Option<f64>,

    /// Choose the most accurate method within this time, such as 16ms or 2s; methods that are
    /// expected to take about as long are run to find out
    #[arg(long, value_name = "TIME", conflicts_with = "error", value_parser = parse::time_target, allow_hyphen_values = true)]
    pub(crate) time: Option<f64>,

    /// Number of frames that share the start of a backend and what is made before the first one
    /// [default: infinitely many]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: Option<u32>,

    /// Size of the picture
    #[arg(long, value_name = "WxH", default_value = "480x270", value_parser = parse::size, allow_hyphen_values = true)]
    pub(crate) size: Size,

    /// Consider only methods whose name contains one of these (see `crepuscular methods`)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,

    /// Backends to consider [default: the CPU, and a GPU unless it is a software adapter]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) backend: Vec<BackendName>,

    /// Then run everything, and print the predictions beside the results
    #[arg(long, conflicts_with = "calibrate")]
    pub(crate) analyze: bool,

    /// Measure what the methods cost on this machine
    #[arg(long, conflicts_with_all = ["error", "time", "frames"])]
    pub(crate) calibrate: bool,

    /// File with the costs of the methods on this machine; --calibrate writes it, otherwise it
    /// is read [default: the one in the user's cache, if there is one]
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    pub(crate) options: SceneOptions,
}

const PLAN_EXAMPLES: &str = "\
Examples:
  crepuscular plan city --error 1%
      The fastest method whose error is at most 1 % of the mean radiance.
  crepuscular plan city --time 16ms --size 960x540
      The most accurate one that draws such a frame in 16 ms.
  crepuscular plan fence --frames 1 --error 0.1%
      The same for a single picture, including what has to be made before it.
  crepuscular plan city --analyze
      Print the predictions beside the results.
  crepuscular plan --calibrate
      Measure what the methods cost on this machine.
  crepuscular render city --error 1% -o city.png
      Render with the choice.";

/// Render one picture: surfaces and airlight
///
/// The method computes the airlight. Surfaces are Lambertian with traced shadows, whatever the
/// method. Lights with --shadows take both from the files. An EXR file holds linear radiance as
/// 32-bit floats. A PNG file is tone-mapped: radiance times 2^exposure, then 1 - exp(-x) per
/// channel, then sRGB.
#[derive(Debug, Args)]
pub(crate) struct Render {
    /// A glTF, GLB, PLY, OBJ, HAIR, VOL, NanoVDB or OpenVDB file, or the name of an embedded scene
    pub(crate) scene: String,

    /// File to write: .png or .exr
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// The method for the airlight, by its name or its title (see `crepuscular methods`)
    /// [default: the pair of --visibility and --airlight; for smoke, or fog that thins out with
    /// altitude, the first method in the list that sees it and runs on the backend]
    ///
    /// A name may end in a reduction of the work. `2x2` or `3x3` lets neighbouring rays share
    /// lights or steps, if the method allows it. `quarter` or `sixteenth`, after that, gathers
    /// this part of the pixels and fills the others from pixels that see the same surface.
    /// `gaussian`, last, fills with a 3 x 3 Gaussian that ignores surfaces.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["visibility", "airlight"])]
    pub(crate) method: Option<String>,

    /// Use the method that is predicted to be the fastest within this error of the airlight:
    /// RMSE over the mean radiance, such as 1% or 0.01 (see `crepuscular plan`)
    #[arg(long, value_name = "ERROR", conflicts_with_all = CHOICES, value_parser = parse::error_target, allow_hyphen_values = true)]
    pub(crate) error: Option<f64>,

    /// Use the method that is predicted to be the most accurate of those that compute the
    /// airlight within this time, such as 16ms or 2s
    #[arg(long, value_name = "TIME", conflicts_with = "error", conflicts_with_all = CHOICES, value_parser = parse::time_target, allow_hyphen_values = true)]
    pub(crate) time: Option<f64>,

    /// Quality of the method, in the unit that `crepuscular methods` lists
    #[arg(long, value_name = "N", conflicts_with_all = ["samples"], value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub(crate) quality: Option<u32>,

    /// Which parts of a ray see the light [default: exact]
    #[arg(long, value_name = "NAME")]
    pub(crate) visibility: Option<String>,

    /// How much light arrives from a lit part [default: quadrature]
    #[arg(long, value_name = "NAME")]
    pub(crate) airlight: Option<String>,

    /// Steps per ray of a march; or voxels along each coordinate (at most 4096; of φ at most
    /// 1024, and a multiple of 32); or voxels along each axis of precomputed shadows (a power
    /// of two) [default: 64 steps, 512 voxels, 2048 voxels of precomputed shadows]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub(crate) samples: Option<u32>,

    /// Nodes of the Gauss-Legendre quadrature for each lit run [default: 8, or 1 where runs are
    /// single samples]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) nodes: Option<u32>,

    /// Where the airlight is computed, the light of hair, and that of surfaces with --shadows;
    /// other surfaces are lit on the CPU
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) backend: PictureBackend,

    /// Let the method compute the shadows of all lights; otherwise lights that nothing blocks
    /// in this view are computed in closed form
    #[arg(long)]
    pub(crate) all_shadows: bool,

    /// Where shadows on surfaces come from [default: traced]
    #[arg(long, value_enum, value_name = "WAY", conflicts_with = "shadows")]
    pub(crate) surface_shadows: Option<SurfaceShadows>,

    /// Files of precomputed shadows (see `bake`), which their lights use in the air and,
    /// filtered, on surfaces. Shadow maps have the shadows of dynamic casters: give the same
    /// --dynamic and --no-shadow as to `bake`, or shadows are missing
    #[arg(long, value_name = "FILES", value_delimiter = ',')]
    pub(crate) shadows: Vec<PathBuf>,

    /// Texels along each side of the filter for precomputed shadows on surfaces; an odd number
    /// [default: 9]
    #[arg(
        long,
        value_name = "TEXELS",
        requires = "shadows",
        allow_negative_numbers = true
    )]
    pub(crate) filter: Option<u32>,

    /// How strands of hair scatter light [default: marschner]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) fibre: Option<FibreName>,

    /// Colour of all hair, instead of the colours in the scene: the share of the light that a
    /// strand does not absorb, 0 to 1 (one number, or R,G,B)
    #[arg(long, value_name = "COLOUR", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) hair_colour: Option<Vec3>,

    /// Size of the picture
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = parse::size, allow_hyphen_values = true)]
    pub(crate) size: Size,

    /// Rays per pixel, whose mean the pixel shows: 1, 4, 9, 16 or any other square number up to
    /// 1024, in a grid that is the same in every pixel and every run
    #[arg(long, value_name = "N", default_value = "1", value_parser = parse::square, allow_negative_numbers = true)]
    pub(crate) spp: Square,

    /// Also write the components of the picture into the EXR file: surfaces, fog,
    /// transmittance, and the surfaces and the fog of each light
    ///
    /// R, G and B are surfaces.R + fog.R and so on. surfaces.*, which include hair, are
    /// emitted.* + indirect.* + the sum of light.N.surfaces.*; fog.* is fog.emitted.* + the sum
    /// of light.N.fog.*. transmittance.* is the share of a surface's light that the fog in
    /// front of it lets through. N is the number of the light, from 0, with its name if it has
    /// one.
    #[arg(long)]
    pub(crate) layers: bool,

    /// Exposure of the PNG in stops [default: the 95th percentile at two thirds of white]
    #[arg(long, value_name = "STOPS", value_parser = parse::finite, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,

    #[command(flatten)]
    pub(crate) indirect: IndirectOptions,

    #[command(flatten)]
    pub(crate) options: SceneOptions,
}

/// The options that say which method to use.
const CHOICES: [&str; 7] = [
    "method",
    "visibility",
    "airlight",
    "quality",
    "samples",
    "nodes",
    "shadows",
];

/// How strands of hair scatter light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FibreName {
    /// Light is reflected, transmitted, or reflected inside the strand, each in a cone
    Marschner,
    /// Diffuse cylinders with a highlight
    KajiyaKay,
}

/// Where shadows on surfaces come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfaceShadows {
    /// From shadow rays to the points that stand for each light
    Traced,
    /// From the voxel that contains the point; --method must be one for area lights, and its
    /// --quality counts here too. Hair, smoke and see-through surfaces then cast no shadow
    Voxels,
    /// From the voxels around the point, interpolated
    Interpolated,
}

/// How the fog scatters light onto surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfaceScattering {
    /// As if nothing cast shadows in the fog: in closed form for point lights and suns in even
    /// fog without bounds, by quadrature for others
    Unshadowed,
    /// With shadow maps of --map texels in the fog
    Shadowed,
}

/// The option for uniform light from all directions.
#[derive(Debug, Args)]
#[command(next_help_heading = "Indirect light")]
pub(crate) struct AmbientOption {
    /// Uniform radiance from all directions (one number, or R,G,B) that the fog scatters once
    /// into the eye, without shadows. Surfaces do not reflect it; in front of the sky an
    /// environment replaces it
    #[arg(long, value_name = "COLOUR", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) ambient: Option<Vec3>,
}

/// Options for light that comes neither directly from a lamp nor out of the air in front of a
/// surface.
#[derive(Debug, Args)]
#[command(next_help_heading = "Indirect light")]
pub(crate) struct IndirectOptions {
    #[command(flatten)]
    pub(crate) ambient: AmbientOption,

    /// Add the light that the fog scatters once onto surfaces
    #[arg(long, value_enum, value_name = "WAY")]
    pub(crate) surface_scattering: Option<SurfaceScattering>,

    /// Light from an environment: a radiance (one number, or R,G,B), or a picture of all
    /// directions (.exr and .hdr are linear, .png and .jpg sRGB) with rows from +Y to -Y, -Z in
    /// the middle of a row, and +X to the right of it
    #[arg(long, value_name = "COLOUR|FILE", allow_hyphen_values = true)]
    pub(crate) environment: Option<String>,

    /// Metres of fog in front of the environment; required in fog without bounds, which would
    /// hide it
    #[arg(
        long,
        value_name = "METRES",
        requires = "environment",
        allow_negative_numbers = true
    )]
    pub(crate) environment_distance: Option<f32>,
}

/// Precompute the shadows that a scene casts from its lights
///
/// Writes compact precomputed voxelized shadows. A light has one grid if a single picture
/// contains all casters (a sun, a spotlight of up to 75 degrees half angle, a light far enough
/// outside of the scene), and six grids otherwise. Closed solids compress best; parts with
/// holes are baked as surfaces, and the output says so. Casters that the file or --dynamic
/// marks as dynamic are left out, so the shadows fit the scene wherever these have moved.
///
/// About every ten seconds, and when the program is told to end (Ctrl-C, SIGTERM), the finished
/// part is written to FILE.part beside the output, and --resume continues from it. The output
/// itself appears when it is complete. A second Ctrl-C ends the program at once. If the output
/// is a pipe or a device there is no FILE.part.
#[derive(Debug, Args)]
pub(crate) struct Bake {
    /// A glTF, GLB, PLY or OBJ file, or the name of an embedded scene
    pub(crate) scene: String,

    /// A light: its number, from 0, its name, or its kind if there is only one of the kind
    /// (point, spot, directional). May be repeated, in the order of the file. "all" is every
    /// light except area lights [default: the only light]
    #[arg(long, value_name = "NAME|INDEX|all", allow_hyphen_values = true)]
    pub(crate) light: Vec<String>,

    /// Voxels along each axis of a grid: a power of two from 8 to 1048576
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4096,
        allow_negative_numbers = true
    )]
    pub(crate) resolution: u32,

    /// Give each light the lowest resolution, up to --resolution, at which nine in ten of the
    /// texels on lit surfaces are at most this wide: in metres, or with a unit, such as 1cm
    #[arg(long, value_name = "LENGTH", value_parser = parse::length, allow_hyphen_values = true)]
    pub(crate) texel: Option<f64>,

    /// How far points of surfaces are moved along their normal, in voxels and in addition to
    /// half the width of a filter, so that surfaces do not shadow themselves
    #[arg(long, value_name = "VOXELS", default_value = "1", value_parser = parse::bias, allow_hyphen_values = true)]
    pub(crate) bias: f32,

    /// Bake only part I of N, such as 2/8, for `merge` to join with the others; the tiles of
    /// all grids are divided evenly
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub(crate) part: Option<Share>,

    /// File to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Continue an interrupted bake of the same scene, lights, resolution, bias and part
    #[arg(long)]
    pub(crate) resume: bool,

    /// Objects, meshes or materials, by name, that cast no shadow; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(crate) no_shadow: Vec<String>,

    /// Objects, meshes or materials, by name, that may move and are left out; may be repeated.
    /// `render --shadows` needs the same names, and those of --no-shadow
    #[arg(long, value_name = "NAME")]
    pub(crate) dynamic: Vec<String>,

    /// How nodes are stored; with --part, `merge` decides
    #[arg(long, value_enum, default_value = "packed")]
    pub(crate) form: NodeForm,

    /// Seed of an embedded scene [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,

    #[command(flatten)]
    pub(crate) surroundings: Surroundings,

    #[command(flatten)]
    pub(crate) file: FileOptions,
}

/// Join the parts of a bake
///
/// Takes the files that `bake --part` wrote, all parts of one bake in any order, and writes the
/// file that a single bake would have written.
#[derive(Debug, Args)]
pub(crate) struct Merge {
    /// The files of all parts
    #[arg(required = true, value_name = "PARTS")]
    pub(crate) parts: Vec<PathBuf>,

    /// File to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// How nodes are stored
    #[arg(long, value_enum, default_value = "packed")]
    pub(crate) form: NodeForm,
}

/// How nodes of precomputed shadows are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum NodeForm {
    /// 32-bit references, the fastest to traverse
    Plain,
    /// As few bits as each level needs: 0.25 to 0.33 of the plain size for closed scenes, 0.38
    /// to 0.49 for open ones
    Packed,
    /// For storage: about half of the packed size for closed scenes; packed again when it is
    /// read
    Compressed,
}

impl NodeForm {
    /// The form in which a bake holds its nodes until they are written.
    pub(crate) fn stored(self) -> Form {
        match self {
            Self::Plain => Form::Plain,
            Self::Packed | Self::Compressed => Form::Packed,
        }
    }
}

/// Describe a file of precomputed shadows, and check that it is valid
#[derive(Debug, Args)]
pub(crate) struct Inspect {
    /// A file that `bake` or `merge` wrote
    pub(crate) file: PathBuf,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// List the methods, what each is for, and who described it
#[derive(Debug, Args)]
pub(crate) struct Methods {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Run every method in every hard case: what breaks, and how large the errors are
///
/// The cases are small pictures that are extreme in one respect: optical depths from 1e-6 to
/// 1e6; lights at the eye, in walls and 1e6 m away; views and spotlights of 0.1° to almost
/// 180°; slivers and coincident triangles; smoke of 1e-6 to 1e6 per metre; scenes of
/// micrometres and of 1000 km. Each method that applies makes each picture on each backend;
/// where there is smoke, only methods that see it do. Each method has a row with its median and
/// worst error against a converged reference, and the case of the worst.
///
/// With --large the cases are those that are hard because there is so much of something: ten
/// million triangles, 100,000 triangles or hairs at one place, smoke of 256³ voxels. They take
/// much more memory and time than the small ones.
///
/// A violation is a pixel that is NaN, infinite or negative, an error above the bound of a
/// method that has one, or a picture of the GPU that differs from that of the CPU by more than
/// twice the method's error. Returns 1 if there is a violation.
#[derive(Debug, Args)]
pub(crate) struct Stress {
    /// Run only methods whose name contains one of these (see `crepuscular methods`)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,

    /// Run only cases whose name contains one of these
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) cases: Vec<String>,

    /// Run the largest cases instead of the small ones
    #[arg(long)]
    pub(crate) large: bool,

    /// Backends to run on [default: all that are present]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) backend: Vec<BackendName>,

    /// Texels along each side of a shadow map
    #[arg(long, value_name = "TEXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(crate) map: u32,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Write a script that lets a shell complete commands and options
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell, which reads the script when it starts; bash reads it from a file in
    /// ~/.local/share/bash-completion/completions
    pub(crate) shell: Shell,
}

/// Write the manual in the format of `man`
#[derive(Debug, Args)]
pub(crate) struct Man {
    /// The command whose page is written [default: the whole program]
    pub(crate) command: Option<String>,
}

/// List the embedded scenes and how hard they are
#[derive(Debug, Args)]
pub(crate) struct Scenes {
    /// Seed of the scenes
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,

    /// Texels along each side of the light map in which the figures are counted
    #[arg(long, value_name = "TEXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) map: u32,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Options for the scene and for its lights.
#[derive(Debug, Args)]
pub(crate) struct SceneOptions {
    /// Seed of an embedded scene [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,

    /// Number of points that stand for an area light
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) lights: u32,

    /// Objects, meshes or materials, by name, that cast no shadow; may be repeated
    #[arg(long, value_name = "NAME")]
    pub(crate) no_shadow: Vec<String>,

    /// Objects, meshes or materials, by name, that may move; may be repeated. Precomputed
    /// shadows leave them out, and shadow maps have their shadows. With --shadows give the same
    /// names as to `bake`, here and for --no-shadow
    #[arg(long, value_name = "NAME")]
    pub(crate) dynamic: Vec<String>,

    /// Texels along each side of a shadow map [default: 1024, 512 with --quick]
    #[arg(long, value_name = "TEXELS", value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(crate) map: Option<u32>,

    #[command(flatten)]
    pub(crate) surroundings: Surroundings,

    #[command(flatten)]
    pub(crate) medium: MediumOptions,

    #[command(flatten)]
    pub(crate) added: AddedOptions,

    #[command(flatten)]
    pub(crate) file: FileOptions,
}

impl SceneOptions {
    /// Texels along each side of the shadow maps of a picture.
    pub(crate) fn map(&self) -> u32 {
        self.map.unwrap_or(1024)
    }
}

/// Options that replace the scene's medium, or parts of it.
#[derive(Debug, Clone, Copy, Default, Args)]
#[command(next_help_heading = "Medium")]
pub(crate) struct MediumOptions {
    /// Scattering coefficient, 1/m: one number or R,G,B
    #[arg(long, value_name = "PER_METRE", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) sigma_s: Option<Vec3>,

    /// Absorption coefficient, 1/m: one number or R,G,B
    #[arg(long, value_name = "PER_METRE", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) sigma_a: Option<Vec3>,

    /// Phase function: how the medium scatters light by angle
    #[arg(long, value_enum)]
    pub(crate) phase: Option<Phase>,

    /// Parameter of the phase function (--phase hg, cornette-shanks, schlick), between -1 and 1
    #[arg(long, value_name = "COSINE", value_parser = parse::mean_cosine, allow_negative_numbers = true)]
    pub(crate) g: Option<f32>,

    /// Restrict the medium to a box, given by two corners
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = parse::bounds, allow_hyphen_values = true)]
    pub(crate) medium_box: Option<Bounds>,
}

/// Phase functions by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Phase {
    /// Equally in all directions
    Isotropic,
    /// As air molecules do: forward and backward alike
    Rayleigh,
    /// Henyey-Greenstein with the mean cosine --g
    Hg,
    /// Cornette-Shanks with the asymmetry --g: Rayleigh with a peak
    CornetteShanks,
    /// Schlick with the eccentricity --g: nearly Henyey-Greenstein
    Schlick,
}

#[cfg(test)]
mod tests;
