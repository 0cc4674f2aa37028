//! Films from the command line.

use crate::common::{fails, names, succeeds};

const SMALL: [&str; 14] = [
    "compare",
    "fence",
    "--size",
    "20x12",
    "--map",
    "64",
    "--quick",
    "--backend",
    "cpu",
    "--methods",
    "march x midpoint,froxels-history",
    "--studies",
    "none",
    "--json",
];

#[test]
fn a_film_is_in_the_report_in_its_table_and_in_the_summary() {
    let place = tempfile::tempdir().unwrap();
    let film = ["--film", "6", "--film-path", "both", "--film-frames"];
    let text = succeeds(place.path(), &[&SMALL[..], &film].concat());
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let film = &summary["film"];
    assert_eq!(
        (film["frames"].as_u64(), film["width"].as_u64()),
        (Some(6), Some(20))
    );
    let rows = film["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 8, "two methods in four shots");
    let report = place.path().join("crepuscular-report");
    let csv = std::fs::read_to_string(report.join("film.csv")).unwrap();
    let mut lines = csv.lines();
    let header = "moved,steps,step_metres,method,title,backend,quality,quality_unit,frames,\
                  mean_radiance,error_rmse,error_change,change_ratio,lag_frames,lag_share,\
                  seconds_frame,things_made,things_reused";
    assert_eq!(lines.next(), Some(header));
    assert_eq!(lines.count(), rows.len());
    for row in rows {
        assert_eq!(row.as_object().unwrap().len(), header.split(',').count());
        let number = |name: &str| row[name].as_f64();
        assert!(number("error_rmse") > Some(0.0) && number("error_change") > Some(0.0));
        match (&row["method"], &row["steps"]) {
            (_, steps) if steps == "large" => assert!(row["lag_frames"].is_null()),
            (method, _) if method == "march x midpoint" => {
                assert_eq!(
                    (number("lag_frames"), number("lag_share")),
                    (Some(0.0), Some(0.0))
                );
            }
            // The light moves, and the history stays behind.
            _ if row["moved"] == "lights" => assert!(number("lag_frames") > Some(0.25), "{row}"),
            _ => {}
        }
    }
    let page = std::fs::read_to_string(report.join("index.html")).unwrap();
    assert!(page.contains("Camera: a third of a pixel") && page.contains("class=\"strips\""));
    // The frames of both methods and of the reference.
    let is_frame = |name: &&String| name.starts_with("film-") && name.ends_with(".png");
    assert_eq!(names(&report).iter().filter(is_frame).count(), 3 * 4 * 6);
    // The next report replaces it with all that is in it, and has no film.
    let text = succeeds(place.path(), &SMALL);
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(summary["film"].is_null());
    assert!(names(&report).iter().all(|name| !name.starts_with("film")));
}

#[test]
fn films_that_cannot_be_made_are_refused() {
    let place = tempfile::tempdir().unwrap();
    for (film, cause) in [
        (&["--film", "0"][..], "5..=600"),
        (&["--film", "1"], "5..=600"),
        (&["--film", "-3"], "5..=600"),
        (&["--film", "100000"], "5..=600"),
        (&["--film", "99999999999999"], "5..=600"),
        (&["--film", "many"], "invalid digit"),
        (&["--film-path", "both"], "--film <FRAMES>"),
        (&["--film-frames"], "--film <FRAMES>"),
        (
            &["--film", "6", "--film-path", "sideways"],
            "camera, light, both",
        ),
    ] {
        fails(place.path(), &[&SMALL[..], film].concat(), cause);
    }
    let large = [
        "compare", "fence", "--size", "960x540", "--fixed", "--film", "60",
    ];
    fails(place.path(), &large, "--film 60");
    assert_eq!(names(place.path()), Vec::<String>::new());
}
