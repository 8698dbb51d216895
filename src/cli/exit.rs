//! What the process returns.

/// Done.
pub const EXIT_OK: u8 = 0;
/// Could not do what was asked.
pub const EXIT_ERROR: u8 = 1;
/// Did not understand what was asked.
pub const EXIT_USAGE: u8 = 2;
/// Ended by Ctrl-C.
pub const EXIT_INTERRUPTED: u8 = 130;

/// All exit codes, and when they come.
pub const EXIT_CODES: &[(u8, &str)] = &[
    (EXIT_OK, "Done."),
    (
        EXIT_ERROR,
        "Something could not be done (a file cannot be read, a view does not exist, there is not enough memory, the standard output does not take what is written, …); one sentence on the standard error says what and how to go on.",
    ),
    (
        EXIT_USAGE,
        "The command line could not be understood, or a file would be written over one that is read or over another one; nothing was done.",
    ),
    (
        EXIT_INTERRUPTED,
        "Ended by Ctrl-C (or SIGTERM): `sundog render` has written the picture as far as it was; a second Ctrl-C ends at once and writes nothing. `cost` and `converge` end without an answer. All other commands end by the signal, and leave nothing half written.",
    ),
];
