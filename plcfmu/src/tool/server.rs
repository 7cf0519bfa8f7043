//! The server of the parameter tool: serves the page, and runs an engine for each tab that shows it.
//!
//! It serves one user on a machine that may have other users. It listens only on 127.0.0.1. All URLs begin with a
//! random token. The URL of the page contains a one-time code: the browser that opens it gets a cookie, which all other
//! requests require. Foreign FMU code runs only for clients that also have a secret contained in the page. The `Host`
//! header must name this server, so a foreign domain that resolves to this address is rejected; `Origin`, if present,
//! must be that of the page; and all changes are POST requests with a content type and a header that a page from
//! another origin may send only after a preflight request, which the server never grants. A WebSocket needs no
//! preflight, but browsers always send its origin.

use crate::tell;
use crate::tool::connections::{self, Trust};
use crate::tool::home::{Collection, File, FmuHome};
use anyhow::{Context, Result, anyhow, ensure};
use axum::body::{Bytes, to_bytes};
use axum::extract::{Query, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONNECTION, CONTENT_LENGTH, CONTENT_TYPE, COOKIE, HOST, HeaderName, HeaderValue, ORIGIN,
    REFERRER_POLICY, SEC_WEBSOCKET_ACCEPT, SEC_WEBSOCKET_KEY, SET_COOKIE, UPGRADE, X_CONTENT_TYPE_OPTIONS,
    X_FRAME_OPTIONS,
};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Router};
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use host::hexadecimal;
use hyper_util::rt::TokioIo;
use serde::{Deserialize, Serialize};
use sha1::Sha1;
use sha2::{Digest, Sha256};
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use tokio::io::AsyncReadExt;
use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::oneshot;
use tokio::time::{sleep, timeout};
use tool::Engine;

/// The maximum size of a request to an engine, in bytes: a parameter file or a recording in Base64.
const LONGEST_MESSAGE: usize = 64 << 20;

/// The maximum size of an FMU, in bytes.
const LARGEST_FMU: usize = 256 << 20;

/// The time limit for receiving the body of a request.
const BODY: Duration = Duration::from_secs(60);

/// The maximum number of tabs with an engine.
const MOST_TABS: usize = 16;

/// How many seconds the engine of a tab outlives its connection. Chromium closes the connections of all pages when the
/// machine goes to sleep; a page that is still open tries to reconnect once a second.
const GRACE: usize = 10;

/// RFC 6455: the hash of a WebSocket's key and this GUID confirms to the browser that its request was understood.
const WEBSOCKET: &[u8] = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

/// The time limit for the engines to shut down.
const FAREWELL: Duration = Duration::from_secs(5);

/// The header that identifies a tab, and the one that identifies its engine.
const TAB: HeaderName = HeaderName::from_static("x-page");
const ENGINE: HeaderName = HeaderName::from_static("x-engine");

/// A server bound to its port.
#[derive(Debug)]
pub struct Server {
    runtime: Runtime,
    listener: TcpListener,
    port: u16,
    access: Access,
}

/// The credentials that admit a browser.
#[derive(Debug)]
struct Access {
    /// The base URL of the page, with the port: `http://127.0.0.1:4711/TOKEN/`.
    base: String,
    /// The first part of all paths.
    token: String,
    /// The value of the cookie that a browser gets in exchange for a code.
    cookie: String,
    /// The secret known only to the page.
    secret: String,
    /// The unused codes; each admits one browser.
    codes: Mutex<Vec<String>>,
}

/// The state shared by all requests.
struct Shared {
    /// The values of the `Host` header that name this server.
    hosts: [String; 2],
    access: Access,
    page: String,
    collection: Arc<Collection>,
    given: Box<ReadFiles>,
    tabs: Mutex<Tabs>,
}

/// Reads the files named on the command line, in their current state.
pub type ReadFiles = dyn Fn() -> Result<Vec<File>> + Send + Sync;

/// The tabs with an engine.
struct Tabs {
    tabs: Vec<Tab>,
    /// The tab of each connection that is open or was closed less than [`GRACE`] seconds ago.
    present: Vec<String>,
    /// The number of engines started so far.
    engines: usize,
    /// Each engine has a clone: the receiver is notified once all of them are dropped.
    alive: Sender<()>,
}

/// A tab with its engine, which runs in its own thread.
struct Tab {
    id: String,
    /// The number of the engine.
    number: usize,
    jobs: Sender<Job>,
    /// Held by every request that the engine has not answered yet.
    at_work: Arc<()>,
}

/// A job for an engine.
type Job = Box<dyn FnOnce(&mut Engine<FmuHome>, &FmuHome) + Send>;

impl Server {
    /// Binds to a port of this machine; 0 selects any free port.
    ///
    /// # Errors
    /// The port is taken or not allowed.
    pub fn bind(port: u16) -> Result<Server> {
        let runtime =
            Builder::new_current_thread().enable_io().enable_time().build().context("the server cannot start")?;
        let bound = runtime.block_on(TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port))));
        let listener = bound.map_err(|error| match error.kind() {
            io::ErrorKind::AddrInUse => {
                anyhow!("port {port} is in use by another program: choose another with --port, or omit --port")
            }
            _ => anyhow!("port {port} cannot be used: {error}: choose another with --port, or omit --port"),
        })?;
        let port = listener.local_addr().context("the server has no address")?.port();
        Ok(Server { runtime, listener, port, access: Access::new(port)? })
    }

    /// An address of the page, valid for one browser.
    ///
    /// # Errors
    /// The system cannot provide random numbers.
    pub fn address(&self) -> Result<String> {
        self.access.address()
    }

    /// The secret that the page needs to run code of foreign FMUs.
    pub fn secret(&self) -> &str {
        &self.access.secret
    }

    /// Serves the page, calls `ready`, and runs until the user interrupts it. Then the engines and the processes of
    /// foreign FMUs are stopped as well.
    ///
    /// # Errors
    /// The system cannot report interruptions by the user.
    pub fn run(self, page: String, collection: Collection, given: Box<ReadFiles>, ready: impl FnOnce()) -> Result<()> {
        let Server { runtime, listener, port, access } = self;
        let (alive, are_over) = mpsc::channel();
        let shared = Arc::new(Shared {
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            access,
            page,
            collection: Arc::new(collection),
            given,
            tabs: Mutex::new(Tabs { tabs: Vec::new(), present: Vec::new(), engines: 0, alive }),
        });
        let routes = routes(&shared);
        runtime.block_on(async {
            let interrupted = interrupted()?;
            tokio::spawn(connections::serve(listener, routes));
            ready();
            interrupted.await;
            anyhow::Ok(())
        })?;
        // First stop the requests, then the engines. The command's own handler of the same signal ends the calls of
        // foreign FMUs: setting its flag here would make it mistake this signal for the second one.
        drop(runtime);
        drop(shared);
        wait(&are_over);
        Ok(())
    }
}

/// Waits until all engines have shut down. An engine whose FMU does not return ends with the process.
fn wait(are_over: &Receiver<()>) {
    let _ = are_over.recv_timeout(FAREWELL);
}

/// Completes when the user interrupts the command or closes its terminal, or the system terminates it.
#[cfg(unix)]
fn interrupted() -> Result<impl Future<Output = ()>> {
    use std::task::Poll;
    use tokio::signal::unix::{SignalKind, signal};
    let listen = |kind| signal(kind).context("system signals cannot be received");
    let kinds = [SignalKind::interrupt(), SignalKind::terminate(), SignalKind::hangup()];
    let mut signals = kinds.into_iter().map(listen).collect::<Result<Vec<_>>>()?;
    Ok(std::future::poll_fn(move |context| {
        let is_there = signals.iter_mut().any(|signal| signal.poll_recv(context).is_ready());
        if is_there { Poll::Ready(()) } else { Poll::Pending }
    }))
}

/// Completes when the user interrupts the command.
#[cfg(windows)]
fn interrupted() -> Result<impl Future<Output = ()>> {
    let mut interrupts = tokio::signal::windows::ctrl_c().context("cannot register a handler for Ctrl-C")?;
    Ok(async move {
        interrupts.recv().await;
    })
}

fn routes(shared: &Arc<Shared>) -> Router {
    let token = &shared.access.token;
    Router::new()
        .route(&format!("/{token}/"), get(page))
        .route(&format!("/{token}/message"), post(message))
        .route(&format!("/{token}/upload"), post(upload))
        .route(&format!("/{token}/accept"), post(accept))
        .route(&format!("/{token}/presence"), get(presence))
        .route(&format!("/{token}/given"), post(given))
        .route_layer(middleware::from_fn_with_state(shared.clone(), known_browser))
        .route(&format!("/{token}/open"), get(open))
        .layer(middleware::from_fn_with_state(shared.clone(), guard))
        .with_state(shared.clone())
}

/// Admits requests that address this server and come from its own page or have no origin.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = match () {
        // RFC 9112: a server must reject a request with two `Host` headers.
        () if request.headers().get_all(HOST).iter().count() > 1 => StatusCode::BAD_REQUEST.into_response(),
        () if shared.allows(request.headers()) => next.run(request).await,
        () => StatusCode::FORBIDDEN.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (CACHE_CONTROL, "no-store"),
        (REFERRER_POLICY, "no-referrer"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Admits requests with the cookie.
async fn known_browser(
    State(shared): State<Arc<Shared>>,
    Extension(trust): Extension<Trust>,
    request: Request,
    next: Next,
) -> Response {
    if !shared.access.knows(request.headers()) {
        let why = "This page is for the browser opened by plcfmu tool. For another browser, use the address printed in \
                   its terminal.";
        return (StatusCode::FORBIDDEN, why).into_response();
    }
    trust.give();
    next.run(request).await
}

/// The code in a URL.
#[derive(Deserialize)]
struct Code {
    code: String,
}

/// Exchanges a code for the browser's cookie, and redirects to the page.
async fn open(State(shared): State<Arc<Shared>>, Query(Code { code }): Query<Code>) -> Response {
    let Access { token, cookie, .. } = &shared.access;
    match shared.access.use_up(&code) {
        Ok(true) => {}
        Ok(false) => {
            let why = "This address has already been used. plcfmu tool has printed another one in its terminal.";
            return (StatusCode::FORBIDDEN, why).into_response();
        }
        Err(error) => return (StatusCode::INTERNAL_SERVER_ERROR, format!("{error:#}")).into_response(),
    }
    let cookie = format!("plcfmu={cookie}; Path=/{token}/; HttpOnly; SameSite=Strict");
    // The cookie is SameSite=Strict: a browser would not send it with a navigation that began on another site, even
    // after a redirect. It sends it with the navigation that this document starts.
    ([(SET_COOKIE, cookie)], Html(leading_to(&format!("/{token}/")))).into_response()
}

/// A document that redirects to a URL, which must not contain characters that need escaping in HTML.
pub fn leading_to(address: &str) -> String {
    format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0; url={address}\">\
         <title>plcfmu tool</title><p><a href=\"{address}\">plcfmu tool</a></p>\n"
    )
}

async fn page(State(shared): State<Arc<Shared>>) -> Html<String> {
    Html(shared.page.clone())
}

/// A request to the engine.
async fn message(State(shared): State<Arc<Shared>>, request: Request) -> Result<Response, Refusal> {
    let (headers, body) = text(request).await?;
    let (answer, number) = shared.ask(&headers, move |engine, _| engine.message(&body)).await?;
    Ok(json(number, answer))
}

/// The file name of an FMU that a page sends.
#[derive(Deserialize)]
struct Upload {
    file: String,
}

/// Receives the user's FMU, which is read but not run.
async fn upload(
    State(shared): State<Arc<Shared>>,
    Query(Upload { file }): Query<Upload>,
    request: Request,
) -> Result<Response, Refusal> {
    let (headers, body) = bytes(request, "application/octet-stream", LARGEST_FMU).await?;
    let (inspected, number) = shared.ask(&headers, move |_, home| home.upload(&file, &body)).await?;
    Ok(json(number, answer(inspected)))
}

/// The user's permission to run the code of an FMU.
#[derive(Deserialize)]
struct Accept {
    fmu: String,
    /// The secret known to the page, but not to anyone who has only seen its URL.
    secret: String,
}

async fn accept(State(shared): State<Arc<Shared>>, request: Request) -> Result<Response, Refusal> {
    let (headers, body) = text(request).await?;
    let accepted: Accept = serde_json::from_str(&body).map_err(|error| Refusal::bad(error.to_string()))?;
    if accepted.secret != shared.access.secret {
        let message = "an FMU may run only with permission given on the page".into();
        return Err(Refusal { status: StatusCode::FORBIDDEN, message });
    }
    let (entry, number) = shared.ask(&headers, move |_, home| home.accept(&accepted.fmu)).await?;
    Ok(json(number, answer(entry)))
}

/// The name of the tab; a page cannot send a header with the request for a WebSocket.
#[derive(Deserialize)]
struct Presence {
    tab: String,
}

/// A connection that a page keeps open: when it ends, so do the engine of the tab and the processes of its FMUs. A page
/// that crashes or is killed cannot send a message, but its connection still ends.
///
/// It is a WebSocket, because all tabs of a browser share six connections for other requests. Neither side sends any
/// data. The first byte is the browser's close frame, or a ping, after which the page reconnects.
async fn presence(
    State(shared): State<Arc<Shared>>,
    Query(Presence { tab }): Query<Presence>,
    mut request: Request,
) -> Result<Response, Refusal> {
    let key =
        request.headers().get(SEC_WEBSOCKET_KEY).ok_or_else(|| Refusal::bad("this address is for a WebSocket"))?;
    let accepted = BASE64_STANDARD.encode(Sha1::digest([key.as_bytes(), WEBSOCKET].concat()));
    let upgraded = hyper::upgrade::on(&mut request);
    shared.tabs().present.push(tab.clone());
    tokio::spawn(async move {
        if let Ok(stream) = upgraded.await {
            let _ = TokioIo::new(stream).read_u8().await;
        }
        // Wait second by second: if the clock keeps running while the machine sleeps (Windows), only one second
        // elapses.
        for _ in 0..GRACE {
            sleep(Duration::from_secs(1)).await;
        }
        shared.tabs().leave(&tab);
    });
    let headers = [(CONNECTION, "upgrade"), (UPGRADE, "websocket"), (SEC_WEBSOCKET_ACCEPT, &accepted)];
    Ok((StatusCode::SWITCHING_PROTOCOLS, headers).into_response())
}

/// The page's version of the files named on the command line.
#[derive(Deserialize)]
struct Version {
    /// A hash of the files.
    hash: String,
}

/// The files named on the command line, if they have changed. A file that an editor is still writing cannot be read;
/// the page asks for it again.
async fn given(State(shared): State<Arc<Shared>>, request: Request) -> Result<Response, Refusal> {
    let (_, body) = text(request).await?;
    let known: Version = serde_json::from_str(&body).map_err(|error| Refusal::bad(error.to_string()))?;
    let files = (shared.given)().and_then(|files| Ok(serde_json::to_string(&files)?));
    let Ok(files) = files else { return Ok(StatusCode::NO_CONTENT.into_response()) };
    let hash = hexadecimal::digits(&Sha256::digest(&files));
    if hash == known.hash {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let changed = format!("{{\"hash\":\"{hash}\",\"files\":{files}}}");
    Ok(([(CONTENT_TYPE, "application/json")], changed).into_response())
}

/// The headers and the body of a request, which must be JSON.
async fn text(request: Request) -> Result<(HeaderMap, String), Refusal> {
    let (headers, body) = bytes(request, "application/json", LONGEST_MESSAGE).await?;
    let text = String::from_utf8(body.into()).map_err(|_| Refusal::bad("the request is not UTF-8"))?;
    Ok((headers, text))
}

/// The headers and the body of a request, which must have this type and at most `most` bytes. A rejected body is not
/// read.
async fn bytes(request: Request, kind: &str, most: usize) -> Result<(HeaderMap, Bytes), Refusal> {
    let (Parts { headers, .. }, body) = request.into_parts();
    if headers.get(CONTENT_TYPE).is_none_or(|given| given.as_bytes() != kind.as_bytes()) {
        let message = format!("the request must have the content type {kind}");
        return Err(Refusal { status: StatusCode::UNSUPPORTED_MEDIA_TYPE, message });
    }
    let too_large = || Refusal {
        status: StatusCode::PAYLOAD_TOO_LARGE,
        message: format!("the request is larger than {} MiB, the maximum that the server accepts", most >> 20),
    };
    let length = headers.get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > most as u64) {
        return Err(too_large());
    }
    // This also fails if the page is gone, in which case nobody reads the reason.
    let body = timeout(BODY, to_bytes(body, most)).await.map_err(|_| Refusal {
        status: StatusCode::REQUEST_TIMEOUT,
        message: format!("the request did not arrive within {} s", BODY.as_secs()),
    })?;
    Ok((headers, body.map_err(|_| too_large())?))
}

/// `{"ok": ...}` or `{"error": {"message": ...}}`, the format of the engine's answers.
fn answer(result: anyhow::Result<impl Serialize>) -> String {
    match result {
        Ok(content) => serde_json::json!({ "ok": content }),
        Err(error) => serde_json::json!({ "error": { "message": format!("{error:#}") } }),
    }
    .to_string()
}

fn json(engine: usize, content: String) -> Response {
    ([(CONTENT_TYPE, HeaderValue::from_static("application/json")), (ENGINE, HeaderValue::from(engine))], content)
        .into_response()
}

/// A rejected request: the status and the reason.
struct Refusal {
    status: StatusCode,
    message: String,
}

impl Refusal {
    fn bad(message: impl Into<String>) -> Refusal {
        Refusal { status: StatusCode::BAD_REQUEST, message: message.into() }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let content = serde_json::json!({ "error": { "message": self.message } }).to_string();
        (self.status, [(CONTENT_TYPE, HeaderValue::from_static("application/json"))], content).into_response()
    }
}

/// 128 random bits as hexadecimal digits.
fn random() -> Result<String> {
    let mut random = [0; 16];
    getrandom::fill(&mut random).map_err(|error| anyhow!("no random numbers are available: {error}"))?;
    Ok(hexadecimal::digits(&random))
}

impl Access {
    fn new(port: u16) -> Result<Access> {
        let (token, codes) = (random()?, Mutex::default());
        let base = format!("http://127.0.0.1:{port}/{token}/");
        Ok(Access { base, token, cookie: random()?, secret: random()?, codes })
    }

    /// An address of the page, with a new one-time code.
    fn address(&self) -> Result<String> {
        let code = random()?;
        let address = format!("{}open?code={code}", self.base);
        self.codes.lock().unwrap_or_else(PoisonError::into_inner).push(code);
        Ok(address)
    }

    /// Consumes a code; returns whether it was unused. After the last one, a URL for another browser is printed.
    fn use_up(&self, code: &str) -> Result<bool> {
        let (is_good, is_last) = {
            let mut codes = self.codes.lock().unwrap_or_else(PoisonError::into_inner);
            let place = codes.iter().position(|one| one == code);
            place.map(|place| codes.remove(place));
            (place.is_some(), codes.is_empty())
        };
        if is_good && is_last {
            tell::raw(&format!("For another browser: {}\n", self.address()?));
        }
        Ok(is_good)
    }

    /// Whether a request has the cookie.
    fn knows(&self, headers: &HeaderMap) -> bool {
        let cookies = headers.get_all(COOKIE).iter().filter_map(|cookies| cookies.to_str().ok());
        let mut cookies = cookies.flat_map(|cookies| cookies.split("; "));
        cookies.any(|cookie| cookie.strip_prefix("plcfmu=") == Some(&self.cookie))
    }
}

impl Shared {
    /// Whether a request is meant for this server and comes from its own page or from no page.
    fn allows(&self, headers: &HeaderMap) -> bool {
        let header = |name| headers.get(name).map(HeaderValue::as_bytes);
        let is_host = |host: &[u8]| self.hosts.iter().any(|own| own.as_bytes() == host);
        let is_ours = |origin: &[u8]| origin.strip_prefix(b"http://").is_some_and(is_host);
        header(HOST).is_some_and(is_host) && header(ORIGIN).is_none_or(is_ours)
    }

    fn tabs(&self) -> MutexGuard<'_, Tabs> {
        self.tabs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The result of `act` in the engine of the requesting tab, and the engine's number.
    async fn ask<T: Send + 'static>(
        &self,
        headers: &HeaderMap,
        act: impl FnOnce(&mut Engine<FmuHome>, &FmuHome) -> T + Send + 'static,
    ) -> Result<(T, usize), Refusal> {
        let id = tab(headers)?;
        let (reply, answer) = oneshot::channel();
        let number = {
            let mut tabs = self.tabs();
            let tab = tabs.tab(id, &self.collection)?;
            let is_at_work = tab.at_work.clone();
            let job: Job = Box::new(move |engine, home| {
                // If the tab has been closed, no one is waiting for the reply.
                let _ = reply.send(act(engine, home));
                drop(is_at_work);
            });
            // If the engine is gone, the job is dropped without an answer.
            let _ = tab.jobs.send(job);
            tab.number
        };
        match answer.await {
            Ok(answer) => Ok((answer, number)),
            Err(_) => {
                self.tabs().tabs.retain(|tab| tab.number != number);
                let message = "the engine of this page has failed: open the loop again".to_string();
                Err(Refusal { status: StatusCode::INTERNAL_SERVER_ERROR, message })
            }
        }
    }
}

/// The name of the requesting tab.
fn tab(headers: &HeaderMap) -> Result<&str, Refusal> {
    let id = headers.get(TAB).and_then(|id| id.to_str().ok()).filter(|id| is_identifier(id));
    id.ok_or_else(|| Refusal::bad("the header X-Page must name the tab: at most 64 letters, digits and -"))
}

fn is_identifier(id: &str) -> bool {
    (1..=64).contains(&id.len()) && id.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-')
}

impl Tabs {
    /// Returns the tab with this name and moves it to the end of the list; a new tab gets a new engine.
    fn tab(&mut self, id: &str, collection: &Arc<Collection>) -> Result<&Tab, Refusal> {
        let tab = match self.tabs.iter().position(|tab| tab.id == id) {
            Some(place) => self.tabs.remove(place),
            None => self
                .open(id, collection)
                .map_err(|error| Refusal { status: StatusCode::SERVICE_UNAVAILABLE, message: format!("{error:#}") })?,
        };
        self.tabs.push(tab);
        let last = self.tabs.len() - 1;
        Ok(&self.tabs[last])
    }

    /// Handles the end of a connection of a tab. With its last connection, the tab loses its engine.
    fn leave(&mut self, id: &str) {
        if let Some(place) = self.present.iter().position(|present| present == id) {
            self.present.swap_remove(place);
        }
        if !self.present.iter().any(|present| present == id) {
            self.tabs.retain(|tab| tab.id != id);
        }
    }

    /// Opens a new tab. If there are too many, the one that has been idle longest loses its engine.
    fn open(&mut self, id: &str, collection: &Arc<Collection>) -> Result<Tab> {
        if self.tabs.len() >= MOST_TABS {
            let idle = self.tabs.iter().position(|tab| Arc::strong_count(&tab.at_work) == 1);
            ensure!(idle.is_some(), "{MOST_TABS} pages are open: close one of them, or wait");
            idle.map(|place| self.tabs.remove(place));
        }
        self.engines += 1;
        let (jobs, to_do) = mpsc::channel::<Job>();
        let (collection, alive) = (collection.clone(), self.alive.clone());
        thread::Builder::new().name(format!("engine {}", self.engines)).spawn(move || {
            let home = FmuHome::new(collection);
            let mut engine = Engine::new(home.clone());
            for job in to_do {
                job(&mut engine, &home);
            }
            drop(engine);
            drop(home);
            drop(alive);
        })?;
        Ok(Tab { id: id.into(), number: self.engines, jobs, at_work: Arc::new(()) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tab_is_named_by_letters_digits_and_dashes() {
        assert!(is_identifier("0f-A9"));
        for id in ["", "a b", "a/b", "ä", &"x".repeat(65)] {
            assert!(!is_identifier(id), "{id}");
        }
    }
}
