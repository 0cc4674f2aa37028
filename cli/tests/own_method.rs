//! A method that only this file knows, in the program.

#![allow(clippy::unwrap_used, reason = "what does not unwrap is a failed test")]

use std::ffi::OsString;
use std::process::ExitCode;

use gpu_backend::{Backend, BufferOf};
use lighting::methods::{
    About, Frame, FrameInputs, Method, MethodError, Registry, Role, RunOn, Verdict,
};

/// The same light from everywhere.
#[derive(Debug)]
struct Constant {
    name: &'static str,
    /// Light for each unit of quality.
    light: f32,
}

const CONSTANT: Constant = Constant {
    name: "constant",
    light: 0.01,
};

impl Method for Constant {
    fn about(&self) -> About {
        About {
            name: self.name.into(),
            title: "constant light",
            purpose: "an example",
            paper: "none",
            quality: "hundredths",
            qualities: &[1, 100],
            quick: &[1, 100],
            pictured: 100,
            usual: 100,
            role: Role::Paper,
            uses_shadow_map: false,
        }
    }

    fn applies(&self, _: &FrameInputs<'_>) -> Verdict {
        Verdict::Applies
    }
}

impl<B: Backend> RunOn<B> for Constant {
    fn add_radiance(
        &self,
        frame: &Frame<'_, B>,
        quality: u32,
        radiance: &mut BufferOf<B, [f32; 4]>,
    ) -> Result<(), MethodError> {
        let light = self.light * quality as f32;
        let all = vec![[light, light, light, 0.0]; frame.inputs.rays.len()];
        *radiance = frame.backend.upload(&all)?;
        Ok(())
    }
}

fn crepuscular(arguments: &[&str]) -> ExitCode {
    with(CONSTANT, arguments)
}

fn with(method: Constant, arguments: &[&str]) -> ExitCode {
    let arguments = ["crepuscular"].iter().chain(arguments);
    let methods = Registry::standard().with(method);
    crepuscular_cli::run(&methods, arguments.map(OsString::from))
}

fn succeeds(arguments: &[&str]) {
    let code = format!("{:?}", crepuscular(arguments));
    assert_eq!(code, format!("{:?}", ExitCode::SUCCESS), "{arguments:?}");
}

#[test]
fn it_is_listed_compared_and_rendered_like_any_other() {
    let place = tempfile::tempdir().unwrap();
    let path = |name: &str| place.path().join(name).to_str().unwrap().to_owned();
    succeeds(&["methods"]);

    let report = path("report");
    succeeds(&[
        "compare",
        "fence",
        "--quick",
        "--size",
        "16x9",
        "--map",
        "64",
        "--time-budget",
        "60",
        "--backend",
        "cpu",
        "--methods",
        "constant,no shadows",
        "--studies",
        "none",
        "--out",
        &report,
    ]);
    let csv = std::fs::read_to_string(place.path().join("report/results.csv")).unwrap();
    let rows: Vec<&str> = csv.lines().filter(|row| row.contains("constant")).collect();
    assert_eq!(rows.len(), 2, "{csv}");
    let page = std::fs::read_to_string(place.path().join("report/index.html")).unwrap();
    assert!(page.contains("constant light"));

    let picture = path("constant.exr");
    succeeds(&[
        "render",
        "fence",
        "--method",
        "constant",
        "--quality",
        "50",
        "--size",
        "8x4",
        "-o",
        &picture,
    ]);
    assert!(std::fs::metadata(&picture).unwrap().len() > 0);

    // What it does not have is an error.
    let wrong = crepuscular(&[
        "render",
        "fence",
        "--method",
        "constant",
        "--samples",
        "5",
        "-o",
        &picture,
    ]);
    assert_ne!(format!("{wrong:?}"), format!("{:?}", ExitCode::SUCCESS));
}

/// What is no light arrives in the picture as it is, and is found there.
#[test]
fn stress_finds_what_is_no_light() {
    for (name, light, code) in [
        ("constant", 0.01, 0),
        ("not a number", f32::NAN, 1),
        ("endless", f32::INFINITY, 1),
        ("negative", -1.0, 1),
    ] {
        let found = with(
            Constant { name, light },
            &["stress", "--methods", name, "--cases", "one pixel,a row"],
        );
        assert_eq!(
            format!("{found:?}"),
            format!("{:?}", ExitCode::from(code)),
            "{name}"
        );
    }
    let bounded = crepuscular(&[
        "stress",
        "--backend",
        "cpu",
        "--methods",
        "exact,no shadows",
    ]);
    assert_eq!(format!("{bounded:?}"), format!("{:?}", ExitCode::SUCCESS));
    for unknown in [
        &["stress", "--cases", "no such case"][..],
        &["stress", "--large", "--cases", "one pixel"],
    ] {
        let found = crepuscular(unknown);
        assert_eq!(format!("{found:?}"), format!("{:?}", ExitCode::from(2)));
    }
}
