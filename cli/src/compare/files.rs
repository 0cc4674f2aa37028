//! The files of a report.

use super::film;
use super::records::records;
use super::results::Results;
use super::studies::STUDIES;
use crate::failure::Failure;
use crate::output::PendingFolder;
use crate::report;

/// The page, which carries the mark of a report.
pub(crate) const PAGE: &str = "index.html";
const RESULTS: &str = "results.csv";

/// The pictures that all others are compared with, and what is behind the air.
const REFERENCE: &str = "airlight-reference.exr";
const SURFACES: &str = "surfaces.exr";

/// Whether a report may have a file of that name.
pub(crate) fn is_ours(name: &str) -> bool {
    [PAGE, RESULTS, SURFACES].contains(&name)
        || STUDIES.iter().any(|study| study.csv == name)
        || film::is_ours(name)
        || name.starts_with("airlight-") && name.ends_with(".exr")
}

/// Writes all of them.
pub(crate) fn write(folder: &PendingFolder, results: &Results) -> Result<(), Failure> {
    folder.write(PAGE, report::page(results)?.as_bytes())?;
    folder.write(RESULTS, &report::csv(&records(results))?)?;
    for study in &results.studies {
        folder.write(study.csv, &report::csv(&study.records)?)?;
    }
    if let Some(film) = &results.film {
        folder.write(film::CSV, &report::csv(&film.study.records)?)?;
    }
    let pictures = &results.pictures;
    folder.write(REFERENCE, &pictures.airlight.exr()?)?;
    folder.write(SURFACES, &pictures.surfaces.exr()?)?;
    for shown in &pictures.methods {
        let name = of_measurement(results, shown.measurement);
        folder.write(&name, &shown.airlight.exr()?)?;
    }
    Ok(())
}

/// The EXR file of a measurement that is shown: `airlight-march-x-midpoint-32-cpu.exr`.
pub(crate) fn of_measurement(results: &Results, index: usize) -> String {
    let m = &results.measurements[index];
    let method = &results.methods[m.method];
    let backend = report::short_name(&m.backend, true);
    format!(
        "airlight-{}-{}-{backend}.exr",
        slug(&method.name),
        m.quality
    )
}

/// A name without what file systems, or shells, take for something else.
pub(super) fn slug(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let text: String = name.chars().map(plain).collect();
    let words = text.split('-').filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::results::tests::{example, example_with_software};

    #[test]
    fn files_have_names_of_their_own_that_are_known_again() {
        let results = example_with_software();
        let all = 0..results.measurements.len();
        let mut names: Vec<String> = all.map(|m| of_measurement(&results, m)).collect();
        assert_eq!(names[0], "airlight-none-x-gauss-8-cpu.exr");
        assert!(names.iter().all(|name| is_ours(name)));
        let number = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), number);
        assert!(!is_ours("holiday.exr") && !is_ours("airlight.txt"));
        assert!(is_ours("airlight.csv"), "a study");
    }

    #[test]
    fn all_files_are_written() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        // The second replaces the first; the study is one of tests.
        let is_ours = |name: &str| is_ours(name) || name == "example.csv";
        for _ in 0..2 {
            let folder = PendingFolder::create(&path, is_ours, PAGE, report::MARK).unwrap();
            write(&folder, &example()).unwrap();
            folder.finish().unwrap();
        }
        let mut names: Vec<_> = std::fs::read_dir(&path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        let expected = [
            "airlight-exact-x-gauss-2-cpu.exr",
            "airlight-reference.exr",
            "example.csv",
            "index.html",
            "results.csv",
            "surfaces.exr",
        ];
        assert_eq!(names, expected);
    }
}
