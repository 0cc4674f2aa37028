//! Which program made a report, with which arguments, and when.

use std::ffi::OsString;
use std::time::{SystemTime, UNIX_EPOCH};

/// What a report says of the run that made it.
#[derive(Debug, Clone)]
pub(crate) struct RunFacts {
    /// The program's version.
    pub(crate) version: &'static str,
    /// The command line, as a shell reads it.
    pub(crate) command: String,
    /// When it began: `2026-03-14 15:09 UTC`.
    pub(crate) date: String,
}

impl RunFacts {
    /// The facts of a run that begins now with these arguments, the first of which is the
    /// program.
    pub(crate) fn now(arguments: &[OsString]) -> Self {
        let seconds = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            version: env!("CARGO_PKG_VERSION"),
            command: command(arguments),
            date: date(seconds.map_or(0, |since| since.as_secs())),
        }
    }
}

/// The arguments behind the program's name, quoted where a shell needs it.
fn command(arguments: &[OsString]) -> String {
    let mut text = String::from("crepuscular");
    for argument in arguments.iter().skip(1) {
        let argument = argument.to_string_lossy();
        let is_plain = |c: char| c.is_alphanumeric() || "-_=+,./:@%".contains(c);
        text += " ";
        if !argument.is_empty() && argument.chars().all(is_plain) {
            text += &argument;
        } else {
            text += &format!("'{}'", argument.replace('\'', "'\\''"));
        }
    }
    text
}

/// The date of so many seconds after the beginning of 1970, by the Gregorian
/// calendar.
fn date(seconds: u64) -> String {
    let (days, minutes) = (seconds / 86_400, seconds / 60 % 1440);
    // Years from March on: the leap day is the last of one.
    let days = days + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, carry) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    let year = 400 * era + year + carry;
    let (hour, minute) = (minutes / 60, minutes % 60);
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, text) in [
            (0, "1970-01-01 00:00 UTC"),
            (951_782_399, "2000-02-28 23:59 UTC"),
            (951_782_400, "2000-02-29 00:00 UTC"),
            (951_868_800, "2000-03-01 00:00 UTC"),
            (1_767_225_599, "2025-12-31 23:59 UTC"),
            (4_107_542_400, "2100-03-01 00:00 UTC"),
        ] {
            assert_eq!(date(seconds), text);
        }
    }

    #[test]
    fn a_command_can_be_given_to_a_shell_again() {
        let arguments = [
            "/usr/bin/it",
            "compare",
            "my scene.glb",
            "--seed",
            "",
            "it's",
        ];
        assert_eq!(
            command(&arguments.map(OsString::from)),
            "crepuscular compare 'my scene.glb' --seed '' 'it'\\''s'"
        );
    }
}
