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
use crate::devices::BackendName;
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
      Which method is the fastest within an error, foreseen in seconds.
  crepuscular render city --visibility exact -o city.png
      One picture with exact shadows.
  crepuscular render street.glb --sigma-s 0.02,0.03,0.05 --phase hg --g 0.6 \\
      --visibility equi-angular --samples 64 -o street.exr
      Bluish haze that scatters forward, 64 equi-angular samples per ray.
  crepuscular bake city --resolution 16384 -o city.cpvs
      Precompute the shadows of a light; `inspect city.cpvs` says what came out.
  crepuscular bake street.glb --light all --texel 1cm -o street.cpvs
      Precompute those of all lights, each as finely as what it shines on asks for.
  crepuscular render city --shadows city.cpvs -o city.png
      Render with them, on surfaces and in the air.
  crepuscular render street.glb --smoke plume.vol@0,1,-4 --hair wig.hair@2,1.6,0,0.01 -o smoke.png
      Smoke and hair beside a scene.
  crepuscular stress --methods exact
      What becomes of a method in cases that are extreme.

Scenes are glTF, GLB, PLY, OBJ, HAIR, VOL or NanoVDB files, or names of embedded ones (`crepuscular scenes`). \
A scene without a camera, a light or a medium is given one, and a note says so. \
Lengths are metres, coefficients 1/m, light is linear RGB.

Results go to standard output; notes, progress and errors to standard error. The exit code is 0, or 1 \
for a comparison that measured nothing, for an error or a time that no method is expected to meet \
and for hard cases with a violation, or 2 \
if something is wrong with what was asked for, or 128 and the number of the signal that ended the \
program: 130 after Ctrl-C. Files appear when they are complete; a program that is killed (SIGKILL) \
can leave one behind beside them whose name begins with .crepuscular-, which can be deleted; an \
earlier report that was being replaced is in .crepuscular-old-… if its folder is missing.";

/// Light and shadow in fog: which method, at which quality, is worth its time?
///
/// A picture of fog is made of two answers per eye ray: which parts of it see
/// the light, and how much light arrives from these parts. This program
/// measures ways to answer them against a converged reference, on your scene,
/// and renders with any of them.
#[derive(Debug, Parser)]
#[command(name = "crepuscular", version, after_long_help = EXAMPLES, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,

    /// No notes, no progress, no summary: only errors, warnings and what was asked for
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
}

impl Arguments {
    /// Reads a command line. What names a method may say is what `methods` has.
    pub(crate) fn read(
        methods: &Registry,
        arguments: impl IntoIterator<Item = OsString>,
    ) -> Result<Self, clap::Error> {
        let command = Self::command(methods);
        Self::from_arg_matches(&command.try_get_matches_from(arguments)?)
    }

    /// The whole command line.
    pub(crate) fn command(methods: &Registry) -> clap::Command {
        with_names(<Self as CommandFactory>::command(), methods)
    }
}

/// The command line with the names of visibility sources and of evaluators.
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
/// Runs every method that applies to the scene at every quality setting, on
/// every backend that is present, and measures its time and its error against
/// a converged reference. Writes a folder with index.html, which needs nothing
/// but a browser, results.csv, and the reference, the surfaces and the airlight of
/// each method as EXR files. A run that measured nothing returns 1. Studies measure one
/// algorithm each, beside the methods: airlight.csv has evaluators of airlight, voxels.csv
/// voxelized shadow volumes, area-lights.csv area lights as many of them, curves.csv
/// curves of transmittance, hair.csv hair lit through them,
/// precomputed-voxelized-shadows.csv what its name says,
/// shadowed-lights.csv all lights with such shadows beside shadow maps, many-lights.csv up
/// to 10,000 lamps in the air of the scene, and marching.csv marches between shadow
/// volumes, on meshes of its own. An interruption (Ctrl-C) during the
/// studies ends them early, and what there is is reported.
///
/// Errors are those of the airlight (surfaces, and what --ambient adds to all pictures,
/// are the same for all methods), in linear radiance, divided by the reference's mean
/// radiance. They depend on the
/// scene, the size and the settings alone. When time is short, repetitions are dropped
/// first, then qualities between the ends, then methods that are neither a paper's nor
/// the baseline; FLIP and the errors of shadow maps by themselves may be missing too.
///
/// A glTF file can bring its medium in the `extras` of its scene: {"medium":
/// {"sigma_s": 0.02, "sigma_a": [0, 0, 0.01], "phase": "henyey-greenstein",
/// "g": 0.6, "box": [[-5, 0, -5], [5, 3, 5]]}}; the options of the medium have the last word.
///
/// Until it is complete the report is in a folder beside DIR that is called
/// DIR.tmp- and a few letters. A run that is killed (SIGKILL) leaves it behind; it
/// can be deleted.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// A glTF, GLB, PLY, OBJ, HAIR, VOL or NanoVDB file, or the name of an embedded scene
    #[arg(default_value = "city")]
    pub(crate) scene: String,

    /// Folder of the report; an earlier report there is replaced
    #[arg(short, long, value_name = "DIR", default_value = "crepuscular-report")]
    pub(crate) out: PathBuf,

    /// Largest picture; made smaller if the time budget asks for it
    /// [default: 480x270, 160x90 with --quick]
    #[arg(long, value_name = "WxH", value_parser = parse::size, allow_hyphen_values = true)]
    pub(crate) size: Option<Size>,

    /// Seconds for everything, from start to report; the picture is halved once or
    /// twice where the lights and triangles of the scene are too many for them, and as
    /// often as it takes if the reference alone would not fit
    /// [default: 150, 14 with --quick]
    #[arg(long, value_name = "SECONDS", value_parser = parse::duration, allow_negative_numbers = true)]
    pub(crate) time_budget: Option<f64>,

    /// A small picture and few qualities
    #[arg(long)]
    pub(crate) quick: bool,

    /// Measure everything at the size asked for, however long it takes
    #[arg(long, conflicts_with = "time_budget")]
    pub(crate) fixed: bool,

    /// Only methods whose name contains one of these (see `crepuscular methods`)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,

    /// Backends to measure [default: all that are present]
    ///
    /// A GPU has to be present if it is asked for here, or if the environment
    /// variable REQUIRE_GPU is 1. CREPUSCULAR_ADAPTER chooses among several by
    /// a part of the name. Times of a software adapter, where the processor
    /// plays the GPU, are measured but represent nothing; the report says so.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) backend: Vec<BackendName>,

    /// Relative error that a pixel of the reference may have; with area lights never less
    /// than 2e-3, or 1e-2 with --quick, and where smoke or uneven fog is seen never less than
    /// 1e-3, or 5e-3 with --quick
    #[arg(long, value_name = "SHARE", default_value = "1e-6", value_parser = parse::tolerance)]
    pub(crate) tolerance: f64,

    /// Make a film of so many frames in each shot, too: how much errors flicker while the
    /// camera or the lights move, and whether methods lag; film.csv has the figures
    ///
    /// A shot with small steps goes forth and back by the same places, and one with large
    /// steps to places that have nothing to do with each other. Pictures are at most as
    /// large as 160x90, or as the comparison's with --fixed. A film takes half of the
    /// --time-budget; without one it adds 4 seconds for each frame of each shot.
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

    /// Put the frames of the film into the report's folder as numbered PNG files, for
    /// programs that compare films
    ///
    /// They are called film-MOVED-STEPS-NAME-0000.png and so on, those of the reference
    /// film-MOVED-STEPS-reference-0000.png, and all have one exposure. ColorVideoVDP
    /// (https://github.com/gfxdisp/ColorVideoVDP) says what a viewer sees of the difference:
    /// cvvdp --test film-camera-small-NAME-%04d.png --ref film-camera-small-reference-%04d.png
    /// --fps 30 --display standard_fhd
    #[arg(long, requires = "film")]
    pub(crate) film_frames: bool,

    /// Let smoke cast shadows into even fog without being seen itself, and leave out fog
    /// that thins out: what is compared then are the methods of shadows in even fog
    #[arg(long)]
    pub(crate) smoke_unseen: bool,

    /// Print what would run and what would not, with reasons, and stop
    #[arg(long)]
    pub(crate) plan: bool,

    /// Only what is expected to be worth it: leave out what another method at some quality
    /// is expected to beat by 2 in both time and error (see `crepuscular plan`)
    #[arg(long)]
    pub(crate) auto: bool,

    /// Print the summary as JSON: the run, the scene, all measurements, the slopes of
    /// the curves, what was left out
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
    /// The camera, by a third of a pixel from frame to frame in one shot and far in another
    Camera,
    /// All lights, by half a texel of their shadow maps and far
    Light,
    /// One after the other
    Both,
}

/// Foresee what each method will cost on a scene and how far off it will be
///
/// Runs methods on a few thousand pixels and compares them with the reference of some of
/// these. Prints what of the airlight is computed and what is left out, and for each method
/// at each quality: seconds before the first frame, seconds per frame, memory, and the error
/// with its standard error. What is too expensive to be tried is foreseen from other
/// qualities of the method, or named. With --error or --time also the choice that `render`
/// makes with the same option, here by the time of one of many frames unless --frames says
/// how many; if nothing meets it, what comes nearest, and the exit code is 1.
///
/// Errors are those of `compare` on the same picture. They do not depend on the clock; times
/// are those of the machine as it is now.
///
/// --calibrate learns what the methods cost on this machine, in seconds per unit of counted
/// work, and writes that to a file, which decides from then on what is cheap enough to be tried:
/// profile.json in the folder crepuscular of the user's cache, or --profile FILE.
#[derive(Debug, Args)]
#[command(after_long_help = PLAN_EXAMPLES)]
pub(crate) struct Plan {
    /// A glTF, GLB, PLY, OBJ, HAIR, VOL or NanoVDB file, or the name of an embedded scene;
    /// with --calibrate any number of them [default with --calibrate: a few embedded ones]
    #[arg(required_unless_present = "calibrate")]
    pub(crate) scene: Vec<String>,

    /// Choose the fastest method within this error: RMSE over the mean radiance, such as 1%
    /// or 0.01
    #[arg(long, value_name = "ERROR", value_parser = parse::error_target, allow_hyphen_values = true)]
    pub(crate) error: Option<f64>,

    /// Choose the most accurate method within this time, such as 16ms or 2s
    #[arg(long, value_name = "TIME", conflicts_with = "error", value_parser = parse::time_target, allow_hyphen_values = true)]
    pub(crate) time: Option<f64>,

    /// Frames that share what is made before the first one [default: infinitely many]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) frames: Option<u32>,

    /// Size of the picture
    #[arg(long, value_name = "WxH", default_value = "480x270", value_parser = parse::size, allow_hyphen_values = true)]
    pub(crate) size: Size,

    /// Only methods whose name contains one of these (see `crepuscular methods`)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,

    /// Backends to foresee [default: the CPU, and a GPU that is one]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) backend: Vec<BackendName>,

    /// Then run everything, and print what was foreseen beside what came out
    #[arg(long, conflicts_with = "calibrate")]
    pub(crate) analyze: bool,

    /// Learn what the methods cost on this machine
    #[arg(long, conflicts_with_all = ["error", "time", "frames"])]
    pub(crate) calibrate: bool,

    /// What the methods cost on this machine: read, or written with --calibrate [default:
    /// the one in the cache, if there is one]
    #[arg(long, value_name = "FILE")]
    pub(crate) profile: Option<PathBuf>,

    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,

    #[command(flatten)]
    pub(crate) options: SceneOptions,
}

const PLAN_EXAMPLES: &str = "\
Examples:
  crepuscular plan city --error 1%
      The fastest method that is off by 1 % of the mean radiance at most.
  crepuscular plan city --time 16ms --size 960x540
      The most accurate one that draws such a frame in 16 ms.
  crepuscular plan fence --frames 1 --error 0.1%
      The same for one picture, with what has to be made before it.
  crepuscular plan city --analyze
      What was foreseen beside what came out.
  crepuscular plan --calibrate
      Learn what the methods cost on this machine.
  crepuscular render city --error 1% -o city.png
      Render with the choice.";

/// Render one picture: surfaces and airlight
///
/// Surfaces are Lambertian with traced shadows, whatever the method; the
/// method is that of the airlight. Lights with --shadows take both from there. An EXR
/// file holds linear radiance as 32-bit floats. A PNG file is tone-mapped: radiance times 2^exposure, then
/// 1 - exp(-x) per channel, then sRGB.
#[derive(Debug, Args)]
pub(crate) struct Render {
    /// A glTF, GLB, PLY, OBJ, HAIR, VOL or NanoVDB file, or the name of an embedded scene
    pub(crate) scene: String,

    /// File to write: .png or .exr
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// The method of the airlight, by its name or its title (see `crepuscular
    /// methods`) [default: exact x quadrature; where there is smoke or fog that thins
    /// out, the first of that list that sees it and runs on the backend]
    ///
    /// A name may end on a reduction of the work. `2x2` or `3x3` lets neighbouring rays share
    /// lights or steps, where the method allows it; `quarter` or `sixteenth`, after that,
    /// gathers that part of the pixels and fills the others from pixels that see the same
    /// surface; `gaussian`, last, fills with a 3 x 3 Gaussian that ignores surfaces.
    #[arg(long, value_name = "NAME", conflicts_with_all = ["visibility", "airlight"])]
    pub(crate) method: Option<String>,

    /// Take the method that is expected to be the fastest within this error of the airlight: RMSE
    /// over the mean radiance, such as 1% or 0.01 (see `crepuscular plan`)
    #[arg(long, value_name = "ERROR", conflicts_with_all = CHOICES, value_parser = parse::error_target, allow_hyphen_values = true)]
    pub(crate) error: Option<f64>,

    /// Take the method that is expected to be the most accurate of those that make the
    /// airlight within this time, such as 16ms or 2s
    #[arg(long, value_name = "TIME", conflicts_with = "error", conflicts_with_all = CHOICES, value_parser = parse::time_target, allow_hyphen_values = true)]
    pub(crate) time: Option<f64>,

    /// The method's quality, whatever that is a number of
    #[arg(long, value_name = "N", conflicts_with_all = ["samples"], value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub(crate) quality: Option<u32>,

    /// Which parts of a ray see the light [default: exact]
    #[arg(long, value_name = "NAME")]
    pub(crate) visibility: Option<String>,

    /// How much light arrives from a part [default: quadrature]
    #[arg(long, value_name = "NAME")]
    pub(crate) airlight: Option<String>,

    /// Steps per ray of a march; voxels along each coordinate (at most 4096; of φ
    /// at most 1024 and a multiple of 32), or along each axis of precomputed
    /// shadows (a power of two)
    /// [default: 64 steps, 512 voxels, 2048 of precomputed shadows]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65536))]
    pub(crate) samples: Option<u32>,

    /// Nodes of the Gauss-Legendre quadrature per lit run
    /// [default: 8, 1 where runs are single samples]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) nodes: Option<u32>,

    /// Where the airlight is made, and the light of surfaces with --shadows; other surfaces
    /// and hair are lit on the CPU
    #[arg(long, value_name = "NAME", default_value = "cpu")]
    pub(crate) backend: BackendName,

    /// Ask the method for the shadows of all lights, also of those that have nothing in
    /// their way in this view, whose light in the air has a closed form
    #[arg(long)]
    pub(crate) all_shadows: bool,

    /// Where shadows on surfaces come from [default: traced]
    #[arg(long, value_enum, value_name = "WAY", conflicts_with = "shadows")]
    pub(crate) surface_shadows: Option<SurfaceShadows>,

    /// Files of precomputed shadows (see `bake`): their lights take them, in the air
    /// and, filtered, on surfaces. Shadow maps have those of what is dynamic: give
    /// the same --dynamic and --no-shadow as to `bake`, or shadows are missing
    #[arg(long, value_name = "FILES", value_delimiter = ',')]
    pub(crate) shadows: Vec<PathBuf>,

    /// Texels along each side of the filter of precomputed shadows on surfaces, odd
    /// [default: 9]
    #[arg(
        long,
        value_name = "TEXELS",
        requires = "shadows",
        allow_negative_numbers = true
    )]
    pub(crate) filter: Option<u32>,

    /// What strands of hair do with light [default: marschner]
    #[arg(long, value_enum, value_name = "NAME")]
    pub(crate) fibre: Option<FibreName>,

    /// Colour of all hair, in place of those of the scene: the share of the light that a
    /// strand does not absorb, 0 to 1 (one number, or R,G,B)
    #[arg(long, value_name = "COLOUR", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) hair_colour: Option<Vec3>,

    /// Size of the picture
    #[arg(long, value_name = "WxH", default_value = "960x540", value_parser = parse::size, allow_hyphen_values = true)]
    pub(crate) size: Size,

    /// Rays per pixel, the mean of which it shows: 1, 4, 9, 16 or any other square up
    /// to 1024, in a grid that is the same in every pixel and every run
    #[arg(long, value_name = "N", default_value = "1", value_parser = parse::square, allow_negative_numbers = true)]
    pub(crate) spp: Square,

    /// Write what the picture consists of into the EXR file too: surfaces, fog,
    /// transmittance, and the surfaces and the fog of each light
    ///
    /// R, G and B are surfaces.R + fog.R and so on. surfaces.*, hair among them, is
    /// emitted.* + indirect.* + the sum of light.N.surfaces.*; fog.* is fog.emitted.* + the
    /// sum of light.N.fog.*. transmittance.* is the share of a surface's light that the
    /// fog before it lets through. N is the light's number, from 0, with its name
    /// if it has one.
    #[arg(long)]
    pub(crate) layers: bool,

    /// Stops for the PNG [default: the 95th percentile at two thirds of white]
    #[arg(long, value_name = "STOPS", value_parser = parse::finite, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,

    #[command(flatten)]
    pub(crate) indirect: IndirectOptions,

    #[command(flatten)]
    pub(crate) options: SceneOptions,
}

/// What says which method a picture is made with.
const CHOICES: [&str; 7] = [
    "method",
    "visibility",
    "airlight",
    "quality",
    "samples",
    "nodes",
    "shadows",
];

/// What strands of hair do with light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FibreName {
    /// Light is reflected, passes, or is reflected inside, each in a cone
    Marschner,
    /// Diffuse cylinders with a highlight
    KajiyaKay,
}

/// Where shadows on surfaces come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfaceShadows {
    /// From shadow rays towards the points that stand for each light
    Traced,
    /// From the voxel that holds the point; --method must be one of area lights, whose
    /// --quality counts here, too. Hair, smoke and see-through surfaces cast no shadow then
    Voxels,
    /// From the voxels around the point, interpolated
    Interpolated,
}

/// How light reaches surfaces by way of the fog.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SurfaceScattering {
    /// As if nothing cast shadows in the fog: in closed form for point lights and suns in
    /// even fog without bounds, by quadrature for the others
    Unshadowed,
    /// With shadow maps of --map texels in the fog
    Shadowed,
}

/// Uniform light from all directions that the fog scatters into the eye.
#[derive(Debug, Args)]
#[command(next_help_heading = "Indirect light")]
pub(crate) struct AmbientOption {
    /// Uniform radiance from all directions (one number, or R,G,B) that the fog scatters into
    /// the eye once, without shadows. Surfaces do not reflect it; an environment takes its place
    /// before the sky
    #[arg(long, value_name = "COLOUR", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) ambient: Option<Vec3>,
}

/// Light that comes neither straight from a lamp nor out of the air before the surface.
#[derive(Debug, Args)]
#[command(next_help_heading = "Indirect light")]
pub(crate) struct IndirectOptions {
    #[command(flatten)]
    pub(crate) ambient: AmbientOption,

    /// Add the light that reaches surfaces by way of the fog, scattered once
    #[arg(long, value_enum, value_name = "WAY")]
    pub(crate) surface_scattering: Option<SurfaceScattering>,

    /// Light from all around: a radiance (one number, or R,G,B), or a picture of all
    /// directions (.exr and .hdr linear, .png and .jpg sRGB): rows from +Y to -Y, -Z in
    /// their middle, +X to its right
    #[arg(long, value_name = "COLOUR|FILE", allow_hyphen_values = true)]
    pub(crate) environment: Option<String>,

    /// Metres of fog before the environment, in fog without bounds, which hides it
    /// otherwise
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
/// Writes compact precomputed voxelized shadows: one grid for a light where a single
/// picture holds all casters (a sun, a spotlight of up to 75 degrees half angle, a light
/// far enough outside of the scene), six otherwise. Closed solids compress best; parts
/// with holes are baked as surfaces, and the output says so. What is dynamic, by the
/// file or by --dynamic, is left out: a file fits its scene wherever that has moved.
///
/// Every ten seconds or so, and when it is told to end (Ctrl-C, SIGTERM), what is
/// finished goes to a file beside the output, FILE.part, from which --resume goes
/// on. The output itself appears when it is complete. A second Ctrl-C ends the
/// program at once. Beside a pipe or a device there is no FILE.part.
#[derive(Debug, Args)]
pub(crate) struct Bake {
    /// A glTF, GLB, PLY or OBJ file, or the name of an embedded scene
    pub(crate) scene: String,

    /// A light: its number, from 0, its name, or its kind if there is only one of it
    /// (point, spot, directional); any number of times, in the order of the file. "all" is
    /// every light but area lights [default: the only light]
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

    /// Give each light the least resolution, up to --resolution, at which nine in ten of the
    /// texels on what it shines on are at most this wide: metres, or with a unit, such as 1cm
    #[arg(long, value_name = "LENGTH", value_parser = parse::length, allow_hyphen_values = true)]
    pub(crate) texel: Option<f64>,

    /// How far surfaces are moved along their normal to be clear of their own shadow, beyond
    /// half the width of a filter, in voxels
    #[arg(long, value_name = "VOXELS", default_value = "1", value_parser = parse::bias, allow_hyphen_values = true)]
    pub(crate) bias: f32,

    /// Only one part of so many, such as 2/8, for `merge` to join with the others: tiles of
    /// all grids are shared out evenly
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub(crate) part: Option<Share>,

    /// File to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,

    /// Go on where an interrupted bake of the same scene, lights, resolution, bias and part
    /// ended
    #[arg(long)]
    pub(crate) resume: bool,

    /// What casts no shadow, by the name of an object, a mesh or a material; any
    /// number of times
    #[arg(long, value_name = "NAME")]
    pub(crate) no_shadow: Vec<String>,

    /// What may move and is left out, by the name of an object, a mesh or a material; any
    /// number of times. `render --shadows` needs the same names, and those of --no-shadow
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
/// Takes the files that `bake --part` wrote, all of one bake and in any order, and writes
/// the file that one bake would have written.
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
    /// 32-bit references: the quickest to walk
    Plain,
    /// As few bits as each level needs: 0.25 to 0.33 of the size for closed
    /// scenes, 0.38 to 0.49 for open ones
    Packed,
    /// For storing: about half of the packed size for closed scenes; packed again when it is
    /// read
    Compressed,
}

impl NodeForm {
    /// How a bake stores nodes for that.
    pub(crate) fn stored(self) -> Form {
        match self {
            Self::Plain => Form::Plain,
            Self::Packed | Self::Compressed => Form::Packed,
        }
    }
}

/// Say what is in a file of precomputed shadows, and whether it is sound
#[derive(Debug, Args)]
pub(crate) struct Inspect {
    /// A file that `bake` or `merge` wrote
    pub(crate) file: PathBuf,

    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// List the methods: what each is for and who described it
#[derive(Debug, Args)]
pub(crate) struct Methods {
    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Run every method in every hard case: what breaks, and how far off it is
///
/// Small pictures that are extreme in one respect: optical depths from 1e-6 to 1e6, lights
/// at the eye, in walls and 1e6 m away, views and spots of 0.1° to almost 180°, slivers and
/// coincident triangles, smoke of 1e-6 to 1e6 a metre, scenes of micrometres and of 1000 km.
/// Each method that applies, and where there is smoke those that see it, makes each picture
/// on each backend. For each there is a row: median and worst error against a converged
/// reference, and where. A violation is a pixel that is not a number, infinite or negative;
/// an error above the bound of a method that has one; or a picture of the GPU that differs
/// from the CPU's by more than twice what the method is off. Returns 1 if there is a
/// violation.
#[derive(Debug, Args)]
pub(crate) struct Stress {
    /// Only methods whose name contains one of these (see `crepuscular methods`)
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) methods: Vec<String>,

    /// Only cases whose name contains one of these
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) cases: Vec<String>,

    /// Backends to run on [default: all that are present]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) backend: Vec<BackendName>,

    /// Texels per side of a shadow map
    #[arg(long, value_name = "TEXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=16384))]
    pub(crate) map: u32,

    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Write a script that lets a shell complete commands and options
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell, which reads the script when it starts: for bash, from a file in
    /// ~/.local/share/bash-completion/completions
    pub(crate) shell: Shell,
}

/// Write the manual in the format of `man`
#[derive(Debug, Args)]
pub(crate) struct Man {
    /// The command whose page is written [default: that of the program]
    pub(crate) command: Option<String>,
}

/// List the embedded scenes and how hard they are
#[derive(Debug, Args)]
pub(crate) struct Scenes {
    /// Seed of the scenes
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,

    /// Resolution of the light map that the figures are counted in
    #[arg(long, value_name = "TEXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) map: u32,

    /// As JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is in the scene and how its lights are treated.
#[derive(Debug, Args)]
pub(crate) struct SceneOptions {
    /// Seed of an embedded scene [default: 1]
    #[arg(long)]
    pub(crate) seed: Option<u64>,

    /// Points that stand for an area light
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) lights: u32,

    /// What casts no shadow, by the name of an object, a mesh or a material; any
    /// number of times
    #[arg(long, value_name = "NAME")]
    pub(crate) no_shadow: Vec<String>,

    /// What may move, by the name of an object, a mesh or a material; any number of times.
    /// Precomputed shadows leave it out, and shadow maps have its shadows: with --shadows
    /// the names that `bake` was given, and those of --no-shadow
    #[arg(long, value_name = "NAME")]
    pub(crate) dynamic: Vec<String>,

    /// Texels per side of a shadow map [default: 1024, 512 with --quick]
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
    /// Texels per side of the shadow maps of a picture.
    pub(crate) fn map(&self) -> u32 {
        self.map.unwrap_or(1024)
    }
}

/// Overrides of the scene's medium.
#[derive(Debug, Clone, Copy, Default, Args)]
#[command(next_help_heading = "Medium")]
pub(crate) struct MediumOptions {
    /// Scattering coefficient, 1/m: one number or R,G,B
    #[arg(long, value_name = "PER_METRE", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) sigma_s: Option<Vec3>,

    /// Absorption coefficient, 1/m: one number or R,G,B
    #[arg(long, value_name = "PER_METRE", value_parser = parse::coefficient, allow_hyphen_values = true)]
    pub(crate) sigma_a: Option<Vec3>,

    /// Phase function
    #[arg(long, value_enum)]
    pub(crate) phase: Option<Phase>,

    /// Parameter of the phase function (--phase hg, cornette-shanks, schlick), between -1 and 1
    #[arg(long, value_name = "COSINE", value_parser = parse::mean_cosine, allow_negative_numbers = true)]
    pub(crate) g: Option<f32>,

    /// Only inside a box, given by two corners
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = parse::bounds, allow_hyphen_values = true)]
    pub(crate) medium_box: Option<Bounds>,
}

/// Phase functions by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Phase {
    /// The same in all directions
    Isotropic,
    /// Air molecules: forward and backward alike
    Rayleigh,
    /// Henyey-Greenstein with the mean cosine --g
    Hg,
    /// Cornette-Shanks with the asymmetry --g: Rayleigh with a peak
    CornetteShanks,
    /// Schlick with the eccentricity --g: nearly Henyey-Greenstein
    Schlick,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Arguments::command(&Registry::standard()).debug_assert();
    }

    #[test]
    fn every_command_explains_itself() {
        let mut command = Arguments::command(&Registry::standard());
        let text = command.render_long_help().to_string();
        assert!(text.contains("Examples:") && text.contains("compare"));
        for sub in command.get_subcommands() {
            assert!(sub.get_about().is_some(), "{}", sub.get_name());
        }
    }
}
