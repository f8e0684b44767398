//! `gable completions` and `gable man`: what shells and `man` know of the command line, made from it.

use std::fs;
use std::path::PathBuf;

use clap::{Command, CommandFactory};

use super::{Cli, Outcome, output};
use crate::error::Error;

const COMPLETIONS: &str = "\
Examples:
  For bash, for this user:
    gable completions bash > ~/.local/share/bash-completion/completions/gable
  For zsh, in a folder of $fpath, and for fish:
    gable completions zsh > ~/.zfunc/_gable
    gable completions fish > ~/.config/fish/completions/gable.fish";

const MAN: &str = "\
Examples:
  Where `man` finds them, for this user:
    gable man ~/.local/share/man/man1
    man gable-reconstruct";

/// What `gable completions` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = COMPLETIONS)]
pub struct CompletionsArgs {
    /// For which shell
    shell: clap_complete::Shell,
}

/// What `gable man` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = MAN)]
pub struct ManArgs {
    /// Folder for the pages: gable.1 and one for each command; pages that are there are replaced
    folder: PathBuf,
}

/// Writes the completions to standard output.
///
/// # Errors
/// Standard output takes no more.
pub fn completions(args: &CompletionsArgs) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "gable", &mut script);
    output::print(&String::from_utf8_lossy(&script))?;
    Ok(0)
}

/// Writes the pages.
///
/// # Errors
/// A page cannot be written.
pub fn man(args: &ManArgs) -> Outcome {
    let fault = |path: &PathBuf| {
        let path = path.clone();
        move |source| Error::io(path, "write", source)
    };
    fs::create_dir_all(&args.folder).map_err(fault(&args.folder))?;
    for (name, page) in pages()? {
        let path = args.folder.join(name);
        fs::write(&path, page).map_err(fault(&path))?;
        output::say(&path.display().to_string());
    }
    Ok(0)
}

/// The name and the text of each page.
fn pages() -> Result<Vec<(String, Vec<u8>)>, Error> {
    let whole = Cli::command();
    let page = |name: &str, command: Command| {
        let mut text = Vec::new();
        let man = clap_mangen::Man::new(command.name(name.to_owned())).title(name.to_uppercase());
        man.render(&mut text).map_err(|source| Error::io(name, "write", source))?;
        Ok((format!("{name}.1"), text))
    };
    let commands =
        whole.get_subcommands().map(|command| page(&format!("gable-{}", command.get_name()), command.clone()));
    std::iter::once(page("gable", whole.clone())).chain(commands).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_its_options_and_examples() {
        let pages = pages().unwrap();
        for command in Cli::command().get_subcommands() {
            let name = format!("gable-{}.1", command.get_name());
            let (_, page) = pages.iter().find(|(known, _)| *known == name).unwrap();
            let page = String::from_utf8_lossy(page).replace("\\-", "-");
            assert!(page.contains("Examples:"), "{name}");
            for option in command.get_arguments().filter_map(clap::Arg::get_long) {
                assert!(page.contains(&format!("--{option}")), "{name} {option}");
            }
        }
    }

    #[test]
    fn completions_know_every_command() {
        for shell in <clap_complete::Shell as clap::ValueEnum>::value_variants() {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "gable", &mut script);
            let script = String::from_utf8_lossy(&script);
            assert!(["reconstruct", "block-step"].iter().all(|word| script.contains(word)), "{shell}");
        }
    }
}
