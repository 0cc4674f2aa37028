//! The order of the house: who may use whom.

use std::fs;
use std::path::{Path, PathBuf};

/// Every crate by its folder and the name under which others depend on it, from
/// the top of the house down. A crate may use those above it.
const HOUSE: [(&str, &str); 11] = [
    ("gpu-backend", "gpu-backend"),
    ("epipolar", "epipolar"),
    ("airlight", "airlight"),
    ("transmittance", "transmittance"),
    ("shadow-dag", "shadow-dag"),
    ("voxel-shadow", "voxel-shadow"),
    ("lighting/scene", "scene"),
    ("lighting", "lighting"),
    ("tests/reference", "reference"),
    ("tests", "crepuscular-tests"),
    ("cli", "cli"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap()
        .into()
}

fn manifest(folder: &str) -> String {
    fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap()
}

/// A line of a table of dependencies.
#[derive(Debug)]
struct Dependency {
    name: String,
    optional: bool,
}

/// The crates of the workspace in a table of a manifest.
fn dependencies(manifest: &str, table: &str) -> Vec<Dependency> {
    manifest
        .lines()
        .map(str::trim)
        .skip_while(|line| *line != format!("[{table}]"))
        .skip(1)
        .take_while(|line| !line.starts_with('['))
        .filter_map(|line| {
            let name = line.split([' ', '.', '=']).next()?;
            let is_ours = HOUSE.iter().any(|(_, ours)| *ours == name);
            is_ours.then(|| Dependency {
                name: name.into(),
                optional: line.contains("optional = true"),
            })
        })
        .collect()
}

fn names(folder: &str, table: &str) -> Vec<String> {
    let all = dependencies(&manifest(folder), table);
    all.into_iter().map(|dependency| dependency.name).collect()
}

fn floor(name: &str) -> usize {
    HOUSE.iter().position(|(_, ours)| *ours == name).unwrap()
}

#[test]
fn every_member_of_the_workspace_has_its_place() {
    let workspace = manifest(".");
    let members = workspace
        .lines()
        .skip_while(|line| *line != "members = [")
        .skip(1)
        .take_while(|line| *line != "]")
        .map(|line| line.trim().trim_matches(['"', ',']));
    let mut members: Vec<&str> = members.collect();
    let mut folders = HOUSE.map(|(folder, _)| folder);
    members.sort_unstable();
    folders.sort_unstable();
    assert_eq!(members, folders);
}

#[test]
fn no_crate_uses_one_below_it() {
    for (folder, name) in HOUSE {
        let used = names(folder, "dependencies");
        assert!(folder == "gpu-backend" || !used.is_empty(), "{folder}");
        for used in used {
            assert!(floor(&used) < floor(name), "{name} uses {used}");
        }
        for used in names(folder, "dev-dependencies") {
            // The tests of every crate may use the reference.
            assert!(
                floor(&used) < floor(name) || used == "reference",
                "tests of {name} use {used}"
            );
        }
        // Nobody hides a dependency in another table.
        let manifest = manifest(folder);
        for table in manifest.lines().filter(|line| line.starts_with('[')) {
            let plain = ["[dependencies]", "[dev-dependencies]"].contains(&table);
            assert!(plain || !table.contains("dependencies"), "{folder} {table}");
        }
    }
}

#[test]
fn algorithms_do_not_know_each_other() {
    for name in ["epipolar", "airlight", "transmittance", "shadow-dag"] {
        assert_eq!(names(name, "dependencies"), ["gpu-backend"], "{name}");
    }
    let mut voxels = names("voxel-shadow", "dependencies");
    voxels.sort_unstable();
    assert_eq!(voxels, ["epipolar", "gpu-backend"]);
}

#[test]
fn a_scene_needs_no_light_transport() {
    let mut used = names("lighting/scene", "dependencies");
    used.sort_unstable();
    assert_eq!(used, ["airlight", "gpu-backend"]);
}

#[test]
fn what_judges_everybody_knows_nobody_unless_asked_for_a_scene() {
    let manifest = manifest("tests/reference");
    let used = dependencies(&manifest, "dependencies");
    assert!(!used.is_empty());
    assert!(used.iter().all(|used| used.optional), "{used:?}");
    assert!(!manifest.contains("default = ["), "features are asked for");
    // The reference uses none of the crates that are measured against it.
    assert!(used.iter().all(|used| floor(&used.name) <= floor("scene")));
    // Published crates forget a development dependency without a version.
    let workspace = self::manifest(".");
    let entry = workspace.lines().find(|line| line.starts_with("reference"));
    assert!(!entry.unwrap().contains("version"));
    for (folder, _) in &HOUSE[..=floor("lighting")] {
        let used = names(folder, "dependencies");
        assert!(!used.contains(&"reference".into()), "{folder}");
    }
}

#[test]
fn the_program_carries_no_test_framework() {
    let manifest = manifest("cli");
    assert!(!names("cli", "dependencies").contains(&"crepuscular-tests".into()));
    for line in manifest.lines() {
        assert!(!line.starts_with("proptest"), "{line}");
        let ours = line.starts_with("reference") || line.starts_with("gpu-backend");
        assert!(
            !ours || !(line.contains("proptest") || line.contains("testing")),
            "{line}"
        );
    }
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let hidden = path.file_name().unwrap().to_string_lossy().starts_with('.');
        if path.is_dir() && !hidden && !path.ends_with("target") {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_property_is_tried_on_the_same_inputs_on_every_run() {
    let mut files = Vec::new();
    sources(&root(), &mut files);
    let mut blocks = 0;
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        // What only speaks of them, in documentation or here.
        let lines = text.lines().map(str::trim_start);
        let code: Vec<&str> = lines.filter(|line| !line.starts_with("//")).collect();
        let count = |start: &str| code.iter().filter(|line| line.starts_with(start)).count();
        let here = count("proptest! {");
        blocks += here;
        assert_eq!(count("#![proptest_config("), here, "{}", file.display());
        let seeded = here == 0 || text.contains("reference::property::cases(");
        let unseeded = here > 0 && text.contains("ProptestConfig::");
        assert!(seeded && !unseeded, "{}", file.display());
    }
    assert!(blocks > 20, "{blocks}");
}
