//! What the command line says of viewers, and what they are told.

use crate::cli::exit::Exit;
use crate::interrupt::Interrupt;
use crate::live::{self, LiveServer};
use crate::plan::Plan;
use clap::Args;
use std::net::SocketAddr;

/// Whether and where runs can be watched.
#[derive(Debug, Args)]
pub struct Watching {
    /// Let Foxglove or Lichtblick watch the runs, by WebSocket, one run at a time; they never change or slow it. At port
    /// 8765 of this machine alone, unless =PORT or =ADDRESS:PORT says otherwise
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "8765",
          value_parser = live::address, conflicts_with_all = ["dry_run", "why", "time", "executor", "export_commands"])]
    live: Option<SocketAddr>,
    /// Hold the runs that are watched to so many seconds of playback a second. They wait for the first viewer, and viewers
    /// can pause, step and change the speed
    #[arg(long, value_name = "SPEED", requires = "live", value_parser = live::speed)]
    live_speed: Option<f64>,
}

impl Watching {
    /// Opens the server, if one is asked for.
    ///
    /// # Errors
    /// An address that can't be served at, with the user's next step.
    pub fn open(&self, interrupt: &Interrupt) -> Result<Option<LiveServer>, (Exit, String)> {
        let Some(address) = self.live else { return Ok(None) };
        LiveServer::open(address, self.live_speed, interrupt).map(Some).map_err(|error| {
            let message = format!(
                "cannot be watched at {address}: {error}\nAnother program may have this port: choose another, such as --live={}",
                live::DEFAULT_PORT + 1
            );
            (Exit::Retryable, message)
        })
    }

    /// Where and how to watch.
    #[must_use]
    pub fn invitation(&self, live: &LiveServer, plan: &Plan) -> String {
        let address = live.address();
        let mut text = format!(
            "Live at ws://{address} (in Foxglove: Open connection, Foxglove WebSocket; layout: {})",
            plan.folder.join("layout.json").display()
        );
        text += match self.live_speed {
            Some(_) => "\n  waiting for the first viewer",
            None => {
                "\n  the runs go as fast as they can: --live-speed 1 keeps the pace of playback"
            }
        };
        if !address.ip().is_loopback() {
            text += "\n  whoever reaches this address can watch";
        }
        text
    }
}
