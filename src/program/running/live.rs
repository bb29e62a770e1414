//! Options for live viewers, and the message that invites them.

use crate::messages::Failure;
use crate::messages::exit;
use clap::Args;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::live::{self, Admission, GnuplotLoop, LiveServer};
use kinetoscope::outputs::sidecars::layout_name;
use kinetoscope::plan::Plan;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Whether and where viewers can connect.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Live view")]
pub(crate) struct LiveArguments {
    /// Serve the runs to Foxglove or Lichtblick by WebSocket, one run at a time, without changing or delaying them. Port
    /// 8765 on this machine only, unless =PORT or =ADDRESS:PORT is given
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "8765",
          value_parser = live::address, conflicts_with_all = ["dry_run", "executor", "export_commands"])]
    live: Option<SocketAddr>,
    /// Limit the runs to this number of seconds of playback per second. They wait for the first viewer. A viewer with controls
    /// for live connections can pause, step and change the speed; Lichtblick has none
    #[arg(long, value_name = "SPEED", requires = "live", value_parser = live::speed)]
    live_speed: Option<f64>,
    /// Admit a viewer that is served as a web page from this origin, such as `https://viewer.example:8080`. Foxglove,
    /// Lichtblick and pages of this machine are always admitted
    #[arg(long, value_name = "ORIGIN", requires = "live", value_parser = live::origin)]
    live_origin: Vec<String>,
    /// Admit viewers that connect to this machine by this name; IP addresses and localhost are always admitted
    #[arg(long, value_name = "NAME", requires = "live", value_parser = live::host)]
    live_host: Vec<String>,
    /// Write the newest frame of each run to DIR as `x y r` lines, with a script that shows it in a loop: cd DIR; gnuplot NAME.gp
    #[arg(long, value_name = "DIR", conflicts_with_all = ["dry_run", "executor", "export_commands"])]
    gnuplot: Option<PathBuf>,
}

impl LiveArguments {
    /// Whether viewers observe the runs.
    pub(crate) fn is_requested(&self) -> bool {
        self.live.is_some() || self.gnuplot.is_some()
    }

    /// Opens the server, if one is requested.
    ///
    /// # Errors
    /// An address that cannot be served.
    pub(crate) fn open(&self, interrupt: &Interrupt) -> Result<Option<LiveServer>, Failure> {
        let Some(address) = self.live else { return Ok(None) };
        let admission =
            Admission { origins: self.live_origin.clone(), hosts: self.live_host.clone() };
        LiveServer::open(address, self.live_speed, admission, interrupt).map(Some).map_err(
            |error| {
                Failure::new(Exit::Retryable, format!("cannot serve viewers at {address}: {error}"))
                    .help(format!(
                        "another program may use this port: choose another, such as --live={}",
                        live::DEFAULT_PORT + 1
                    ))
            },
        )
    }

    /// Creates the folder of the files for gnuplot, if one is requested.
    ///
    /// # Errors
    /// A folder that cannot be created.
    pub(crate) fn gnuplot_loop(&self) -> Result<Option<GnuplotLoop>, Failure> {
        let Some(folder) = &self.gnuplot else { return Ok(None) };
        GnuplotLoop::create(folder).map(Some).map_err(|error| {
            let what = format!("cannot create the folder {}: {error}", shown_path(folder));
            Failure::new(exit::of_output(&error), what)
                .help("name another folder with --gnuplot DIR")
        })
    }

    /// The address for viewers, and how to connect.
    #[must_use]
    pub(crate) fn invitation(&self, live: &LiveServer, plan: &Plan) -> String {
        let address = live.address();
        let mut text = format!(
            "Live at ws://{address} (in Foxglove: Open connection, Foxglove WebSocket; layout: {})",
            shown_path(&plan.folder.join(layout_name(&plan.folder)))
        );
        text += match self.live_speed {
            Some(_) => "\n  waiting for the first viewer",
            None => {
                "\n  the runs are not slowed down: --live-speed 1 limits them to playback speed"
            }
        };
        if !address.ip().is_loopback() {
            text += "\n  this address is open to every machine that reaches it, by IP address or by a name given with --live-host";
        }
        text
    }
}
