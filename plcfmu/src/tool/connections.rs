//! The connections of the server: their number is limited, and idle ones are closed.
//!
//! Any program on this machine can connect. A connection becomes trusted with the first request that has the page's
//! cookie. It must do so within `INTRODUCTION`; if there are too many connections, untrusted ones are closed first.

use axum::Router;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::{Sleep, sleep, timeout};

/// The maximum number of open connections; a browser opens six. WebSockets, one for each tab, are not counted.
const MOST: usize = 64;

/// The time limit for a connection to present the cookie.
const INTRODUCTION: Duration = Duration::from_secs(10);

/// The time limit for the head of a request, including the idle time before it.
const HEAD: Duration = Duration::from_secs(60);

/// How long the other side may leave an answer unread.
const UNREAD: Duration = Duration::from_secs(30);

/// How long to wait before accepting again if the system has no resources for another connection.
const NO_ROOM: Duration = Duration::from_millis(50);

/// Whether a connection has presented the cookie. Attached to each of its requests as an extension.
#[derive(Clone, Debug, Default)]
pub struct Trust(Arc<AtomicBool>);

impl Trust {
    /// Marks the connection as trusted.
    pub fn give(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_given(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Serves all connections until the returned future is dropped.
pub async fn serve(listener: TcpListener, routes: Router) {
    let mut open: VecDeque<(Trust, AbortHandle)> = VecDeque::new();
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            sleep(NO_ROOM).await;
            continue;
        };
        open.retain(|(_, task)| !task.is_finished());
        if open.len() >= MOST {
            // If all are trusted, the new connection is closed.
            let Some(place) = open.iter().position(|(trust, _)| !trust.is_given()) else { continue };
            if let Some((_, task)) = open.remove(place) {
                task.abort();
            }
        }
        let trust = Trust::default();
        let task = tokio::spawn(answer(stream, routes.clone(), trust.clone()));
        open.push_back((trust, task.abort_handle()));
        // Lets an aborted task close its connection.
        tokio::task::yield_now().await;
    }
}

async fn answer(stream: TcpStream, routes: Router, trust: Trust) {
    let service = TowerToHyperService::new(routes);
    let given = trust.clone();
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(given.clone());
        service.call(request)
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(HEAD);
    let connection = http.serve_connection(TokioIo::new(Stream { stream, unread: None }), service);
    let mut connection = std::pin::pin!(connection.with_upgrades());
    // An error on a connection ends that connection only.
    if timeout(INTRODUCTION, &mut connection).await.is_err() && trust.is_given() {
        let _ = connection.await;
    }
}

/// A connection that ends if the other side stops reading.
struct Stream {
    stream: TcpStream,
    /// The deadline for the other side to read; `None` while it is reading.
    unread: Option<Pin<Box<Sleep>>>,
}

impl Stream {
    /// Passes on the result of a write, but fails if nothing could be written for [`UNREAD`].
    fn limited<T>(&mut self, context: &mut Context<'_>, written: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if written.is_ready() {
            self.unread = None;
            return written;
        }
        let unread = self.unread.get_or_insert_with(|| Box::pin(sleep(UNREAD)));
        unread.as_mut().poll(context).map(|()| Err(io::ErrorKind::TimedOut.into()))
    }
}

impl AsyncRead for Stream {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, to: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, to)
    }
}

impl AsyncWrite for Stream {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.limited(context, written)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::Extension;
    use axum::routing::get;
    use std::net::Ipv4Addr;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::runtime::Builder;
    use tokio::time::Instant;

    const ASK: &[u8] = b"GET /trust HTTP/1.1\r\nHost: x\r\n\r\n";

    /// Runs `test` with a server, on a clock that advances by itself when nothing else is to be done.
    fn with_server<F: Future<Output = ()>>(test: impl FnOnce(std::net::SocketAddr) -> F) {
        let runtime = Builder::new_current_thread().enable_all().start_paused(true).build().unwrap();
        runtime.block_on(async {
            let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
            let address = listener.local_addr().unwrap();
            let endless = || async { "x".repeat(64 << 20) };
            let trust = |Extension(trust): Extension<Trust>| async move { trust.give() };
            let routes = Router::new().route("/trust", get(trust)).route("/long", get(endless));
            tokio::spawn(serve(listener, routes));
            test(address).await;
        });
    }

    /// How long a connection lives after it has sent this.
    async fn life(address: std::net::SocketAddr, sent: &[u8]) -> Duration {
        let mut stream = TcpStream::connect(address).await.unwrap();
        let start = Instant::now();
        stream.write_all(sent).await.unwrap();
        let _ = stream.read_to_end(&mut Vec::new()).await;
        start.elapsed()
    }

    #[test]
    fn a_connection_without_the_cookie_ends_soon_whatever_it_sends() {
        with_server(|address| async move {
            for sent in [&b""[..], b"GET /trust HT", b"POST /trust HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\nx"] {
                let life = life(address, sent).await;
                assert!(life < INTRODUCTION + Duration::from_secs(1), "{life:?}");
            }
        });
    }

    #[test]
    fn a_trusted_connection_may_wait_for_longer_and_not_for_ever() {
        with_server(|address| async move {
            let life = life(address, ASK).await;
            assert!(life > INTRODUCTION && life < HEAD + Duration::from_secs(1), "{life:?}");
        });
    }

    #[test]
    fn an_answer_that_nobody_reads_ends_the_connection() {
        with_server(|address| async move {
            let mut stream = TcpStream::connect(address).await.unwrap();
            stream.write_all(ASK).await.unwrap();
            stream.write_all(&String::from_utf8_lossy(ASK).replace("trust", "long").into_bytes()).await.unwrap();
            sleep(UNREAD + Duration::from_secs(1)).await;
            let mut rest = Vec::new();
            let _ = stream.read_to_end(&mut rest).await;
            assert!(rest.len() < 64 << 20);
        });
    }

    #[test]
    fn the_oldest_connection_without_the_cookie_gives_way() {
        with_server(|address| async move {
            let mut trusted = TcpStream::connect(address).await.unwrap();
            trusted.write_all(ASK).await.unwrap();
            let mut head = [0; 12];
            trusted.read_exact(&mut head).await.unwrap();
            let start = Instant::now();
            let mut idle = Vec::new();
            for _ in 0..MOST {
                idle.push(TcpStream::connect(address).await.unwrap());
            }
            assert_eq!(idle[0].read(&mut [0; 1]).await.unwrap(), 0);
            assert!(start.elapsed() < INTRODUCTION);
            trusted.write_all(ASK).await.unwrap();
            assert!(trusted.read(&mut [0; 1]).await.unwrap() == 1);
        });
    }
}
