//! `plcfmu mcp`: the commands for agents and editors, over the Model Context Protocol.
//!
//! Each tool runs the command of the same name in a separate process, so the server survives a command that hangs,
//! crashes or prints too much. The tool's arguments are derived from the command's options.

mod folder;
mod offer;

use super::time_limit;
use crate::interruption;
use anyhow::{Context, Result, bail, ensure};
use folder::Folder;
use host::child::TICK;
use offer::{OFFERS, Offer};
use rmcp::model::{
    CallToolRequestParams, CallToolResponse, CallToolResult, ContentBlock, Implementation, JsonObject, ListToolsResult,
    PaginatedRequestParams, ServerCapabilities, ServerConfig, Tool,
};
use rmcp::service::{RequestContext, RoleServer};
use rmcp::transport::stdio;
use rmcp::{ErrorData, ServerHandler, ServiceExt};
use std::env;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::atomic::Ordering;
use std::time::Duration;
use study::Interrupted;
use tokio::io::{AsyncRead, AsyncReadExt};
use tokio::process::Command;
use tokio::runtime::Builder;
use tokio::sync::Mutex;
use tokio::time::{sleep, timeout};
use tokio::{select, try_join};

/// The instructions for the agent, which a client receives when it connects.
const INSTRUCTIONS: &str = "PLC programs (SCL, LAD, FBD, data blocks and tag tables, as TIA Portal exports them) and FMUs: check them, \
    print a program as SCL, build an FMU from it, test its logic, run it with signals over time. Paths are relative to the folder in which \
    plcfmu was started and must not leave it. To specify a program, pass all its files together, or their folder.";

/// The maximum length of each output of a command, standard output and standard error, in bytes.
const LONGEST: u64 = 16 << 20;

/// Serve agents and editors with check, show, build, test and run (Model Context Protocol)
///
/// Communicates over standard input and output, and serves only the files in the folder in which it is started. The
/// tool `run` executes the native code of FMUs: start the server only where you trust the FMUs.
#[derive(clap::Args, Clone, Debug)]
pub struct Options {
    /// Time limit for a tool call, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300.0, value_parser = time_limit)]
    time_limit: f64,
}

/// Serves a client until it closes standard input, or the user interrupts the command.
///
/// # Errors
/// The current folder cannot be read, or the first message is not a request to initialize.
pub fn run(options: &Options) -> Result<()> {
    let interrupted = interruption::flag();
    let server = Server {
        program: env::current_exe().context("plcfmu cannot find its own program file")?,
        folder: Folder::current()?,
        limit: Duration::from_secs_f64(options.time_limit),
        turn: Mutex::default(),
    };
    let runtime = Builder::new_current_thread().enable_all().build().context("the server cannot start")?;
    let done = runtime.block_on(async {
        let serve = async {
            let no_client = "no Model Context Protocol client on standard input";
            server.serve(stdio()).await.context(no_client)?.waiting().await?;
            Ok(())
        };
        let interruption = async {
            while !interrupted.load(Ordering::Relaxed) {
                sleep(TICK).await;
            }
        };
        select! {
            done = serve => done,
            () = interruption => bail!(Interrupted("the server has ended".into())),
        }
    });
    // Does not wait for the thread that may still be reading standard input.
    runtime.shutdown_background();
    done
}

struct Server {
    program: PathBuf,
    folder: Folder,
    limit: Duration,
    /// Held while a command runs, so that only one runs at a time: a thousand requests must not start a thousand
    /// processes.
    turn: Mutex<()>,
}

impl ServerHandler for Server {
    fn get_info(&self) -> ServerConfig {
        ServerConfig::new(ServerCapabilities::builder().enable_tools().build())
            .with_server_info(Implementation::new("plcfmu", env!("CARGO_PKG_VERSION")))
            .with_instructions(INSTRUCTIONS)
    }

    async fn list_tools(
        &self,
        _: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListToolsResult, ErrorData> {
        let tools = OFFERS.iter().map(|offer| Tool::new(offer.name, offer.about, offer.schema()));
        Ok(ListToolsResult::with_all_items(tools.collect()))
    }

    async fn call_tool(
        &self,
        request: CallToolRequestParams,
        context: RequestContext<RoleServer>,
    ) -> Result<CallToolResponse, ErrorData> {
        let names = || OFFERS.map(|offer| offer.name).join(", ");
        let unknown = || ErrorData::invalid_params(format!("no tool {:?}; available: {}", request.name, names()), None);
        let offer = OFFERS.iter().find(|offer| offer.name == request.name).ok_or_else(unknown)?;
        let given = request.arguments.unwrap_or_default();
        let answer = select! {
            answer = self.answer(offer, &given) => answer,
            // The client is no longer waiting for the answer.
            () = context.ct.cancelled() => return Err(ErrorData::internal_error("cancelled", None)),
        };
        let refused = |error| CallToolResult::error(vec![ContentBlock::text(format!("{error:#}"))]);
        Ok(answer.unwrap_or_else(refused).into())
    }
}

impl Server {
    /// The output of the command for a request: its results, followed by its warnings and notes.
    async fn answer(&self, offer: &Offer, request: &JsonObject) -> Result<CallToolResult> {
        let arguments = offer.arguments(request, &self.folder)?;
        let _turn = self.turn.lock().await;
        let mut process = Command::new(&self.program)
            .args([offer.name, "--color=never"])
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .kill_on_drop(true)
            .spawn()
            .context("plcfmu cannot start itself")?;
        let (printed, told) = (process.stdout.take(), process.stderr.take());
        let ended =
            timeout(self.limit, async { try_join!(read(printed), read(told), async { Ok(process.wait().await?) }) });
        let slow = || {
            let seconds = self.limit.as_secs_f64();
            format!("{} was stopped after {seconds} s; 'plcfmu mcp --time-limit SECONDS' allows more", offer.name)
        };
        let (printed, told, status) = ended.await.ok().with_context(slow)??;
        // A command that prints its findings as JSON has answered, even if its exit code reports a failure.
        let is_answer = status.success() || offer.is_json && !printed.is_empty();
        let texts = [printed, told].into_iter().filter(|text| !text.is_empty()).map(ContentBlock::text).collect();
        Ok(if is_answer { CallToolResult::success(texts) } else { CallToolResult::error(texts) })
    }
}

/// Reads a pipe to its end. Fails if it delivers more than [`LONGEST`] bytes.
async fn read(pipe: Option<impl AsyncRead + Unpin>) -> Result<String> {
    let mut bytes = Vec::new();
    let pipe = pipe.context("the process has no output")?;
    pipe.take(LONGEST + 1).read_to_end(&mut bytes).await?;
    ensure!(bytes.len() as u64 <= LONGEST, "the answer is longer than {} MiB: request less", LONGEST >> 20);
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
