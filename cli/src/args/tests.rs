use std::fs;
use std::path::Path;

use lighting::scene::procedural::Embedded;

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

/// What a shell makes of a line: words, without quotation marks, up to a comment.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for character in line.chars() {
        let word = words.last_mut().expect("there is always one");
        match character {
            '"' => quoted = !quoted,
            '#' if !quoted && word.is_empty() => break,
            ' ' if !quoted && !word.is_empty() => words.push(String::new()),
            ' ' if !quoted => {}
            _ => word.push(character),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The command lines of this program in a page or a help text, each without the program's name.
fn command_lines(text: &str) -> Vec<Vec<String>> {
    let joined = text.replace("\\\n", " ");
    let shown = joined.lines().filter_map(|line| {
        let line = line.trim();
        let typed = line.strip_prefix("$ ").unwrap_or(line);
        typed
            .strip_prefix("cargo run --release -- ")
            .or_else(|| typed.strip_prefix("crepuscular "))
    });
    // In running text: between single backticks.
    let mentioned = joined
        .split('`')
        .filter_map(|code| code.strip_prefix("crepuscular "));
    let lines = shown
        .chain(mentioned)
        .filter(|line| line.starts_with(|c: char| c.is_ascii_lowercase()));
    lines.map(words).collect()
}

/// The scenes that a command reads.
fn scenes(command: &Command) -> &[String] {
    match command {
        Command::Compare(compare) => std::slice::from_ref(&compare.scene),
        Command::Plan(plan) => &plan.scene,
        Command::Render(render) => std::slice::from_ref(&render.scene),
        Command::Bake(bake) => std::slice::from_ref(&bake.scene),
        _ => &[],
    }
}

/// Every command line that the documentation shows is one that the program takes, and a scene
/// in it is a file, by its ending, or embedded.
#[test]
fn documented_command_lines_are_taken() {
    let methods = Registry::standard();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let page = |name: &str| {
        (
            name.to_string(),
            fs::read_to_string(root.join(name)).expect("a page"),
        )
    };
    let mut texts: Vec<_> = [
        "README.md",
        "docs/choosing.md",
        "docs/film.md",
        "docs/papers.md",
    ]
    .map(page)
    .into();
    let mut command = Arguments::command(&methods).term_width(usize::MAX);
    texts.push(("--help".into(), command.render_long_help().to_string()));
    for sub in command.get_subcommands_mut() {
        texts.push((
            format!("{} --help", sub.get_name()),
            sub.render_long_help().to_string(),
        ));
    }

    let mut found = 0;
    for (page, text) in &texts {
        for words in command_lines(text) {
            if let [name] = &words[..] {
                // A command that is only named.
                assert!(command.find_subcommand(name).is_some(), "{page}: {name}");
                continue;
            }
            let line = ["crepuscular".into()]
                .into_iter()
                .chain(words.iter().map(OsString::from));
            let read = Arguments::read(&methods, line);
            let read = read.unwrap_or_else(|error| panic!("{page}: {words:?}: {error}"));
            for scene in scenes(&read.command) {
                let known =
                    Path::new(scene).extension().is_some() || Embedded::from_name(scene).is_some();
                assert!(
                    known || scene == "SCENE",
                    "{page}: {words:?}: there is no scene {scene}"
                );
            }
            found += 1;
        }
    }
    assert!(
        found > 30,
        "only {found}: are they written in another way now?"
    );
}
