// SPDX-License-Identifier: Apache-2.0
#include "apps/page_server.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read_until.hpp>
#include <asio/steady_timer.hpp>
#include <asio/write.hpp>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "sim/input_error.h"
#include "sim/text.h"

namespace sinew::apps {
namespace {

using asio::ip::tcp;
using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t most_kept = 40'000;        // events: more than an hour at ten a second
constexpr std::size_t most_browsers = 16;        // at once
constexpr std::size_t longest_request = 16'384;  // bytes
constexpr std::size_t longest_write = 65'536;    // bytes, of events at once
constexpr auto between_turns = std::chrono::milliseconds(20);
constexpr auto longest_question = std::chrono::seconds(10);  // for a request to be whole, and for its answer to be taken
constexpr auto longest_farewell = std::chrono::seconds(1);

// The value of a header, by its name in lower case; empty where it is not there.
std::string header_of(const std::string& request, const std::string& name) {
  for (std::size_t at = request.find("\r\n"); at != std::string::npos; at = request.find("\r\n", at + 2)) {
    const std::size_t colon = request.find(':', at);
    if (colon == std::string::npos || colon - at - 2 != name.size()) continue;
    std::string found = request.substr(at + 2, name.size());
    for (char& c : found)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (found != name) continue;
    const std::size_t begins = request.find_first_not_of(" \t", colon + 1), ends = request.find("\r\n", colon);
    return begins < ends ? request.substr(begins, ends - begins) : "";
  }
  return "";
}

std::string http_answer(const std::string& status, const std::string& more, const std::string& content = "") {
  return "HTTP/1.1 " + status + "\r\nConnection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n" + more +
         "Content-Length: " + std::to_string(content.size()) + "\r\n\r\n" + content;
}

}  // namespace

class PageServer::Implementation {
 public:
  explicit Implementation(int port) : port_(port), acceptor_(context_), timer_(context_) {
    // Of a file descriptor that no child process inherits: an emulator would keep the port after us.
    const int descriptor = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (descriptor < 0) throw std::runtime_error(std::string("socket: ") + std::strerror(errno));
    acceptor_.assign(tcp::v4(), descriptor);
    const int yes = 1;
    ::setsockopt(descriptor, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_port = htons(static_cast<std::uint16_t>(port));
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0 || ::listen(descriptor, 16) != 0)
      throw sim::InputError({.key = "--page",
                             .value = std::to_string(port),
                             .advice = errno == EADDRINUSE ? "another program has this port of 127.0.0.1: name another, such as " +
                                                                 std::to_string(port < 65535 ? port + 1 : port - 1)
                                                           : std::string(std::strerror(errno))});
  }

  ~Implementation() {
    ended_.store(true, std::memory_order_release);
    if (thread_.joinable()) thread_.join();
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void start(std::string document, std::string opening, std::function<void(const Emit&)> next) {
    document_ = http_answer("200 OK", "Content-Type: text/html; charset=utf-8\r\n", document);
    opening_ = std::move(opening);
    next_ = std::move(next);
    // Tells this story from that of a program before, at whose events a browser may have stopped.
    story_ = std::to_string(::getpid()) + "." + std::to_string(SteadyClock::now().time_since_epoch().count());
    // Signals are for the threads that were there before.
    sigset_t all, before;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] {
      try {
        look();
        context_.run();
      } catch (const std::exception&) {  // out of memory: the page ends, and nothing else
      }
    });
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

 private:
  struct Browser {
    explicit Browser(asio::io_context& context) : socket(context) {}
    tcp::socket socket;
    std::string request, out;
    std::uint64_t next = 0;  // event
    bool follows = false, writing = false, closes = false;
    SteadyClock::time_point since = SteadyClock::now();
  };
  using BrowserPointer = std::shared_ptr<Browser>;

  // One browser; the next one is waited for at the next look.
  void accept() {
    accepts_ = true;
    acceptor_.async_wait(tcp::acceptor::wait_read, [this](const asio::error_code& error) {
      accepts_ = false;
      if (error) return;
      const int descriptor = ::accept4(acceptor_.native_handle(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
      if (descriptor >= 0 && browsers_.size() >= most_browsers) {
        ::close(descriptor);
      } else if (descriptor >= 0) {
        const auto browser = std::make_shared<Browser>(context_);
        browser->socket.assign(tcp::v4(), descriptor);
        browsers_.insert(browser);
        asio::async_read_until(browser->socket, asio::dynamic_buffer(browser->request, longest_request), "\r\n\r\n",
                               [this, browser](const asio::error_code& wrong, std::size_t) { wrong ? close(browser) : reply(browser); });
      }
    });
  }

  void reply(const BrowserPointer& browser) {
    const std::string& request = browser->request;
    const std::string line = request.substr(0, request.find("\r\n"));
    const std::size_t after_method = line.find(' '), after_path = line.find(' ', after_method + 1);
    if (after_method == std::string::npos || after_path == std::string::npos || line.compare(after_path, 6, " HTTP/") != 0)
      return answer_with(browser, http_answer("400 Bad Request", ""));
    const std::string path = line.substr(after_method + 1, after_path - after_method - 1);
    // A page of elsewhere whose name was made to lead here (DNS rebinding) is not answered.
    const std::string host = header_of(request, "host"), at = ":" + std::to_string(port_);
    if (host != "127.0.0.1" + at && host != "localhost" + at) return answer_with(browser, http_answer("403 Forbidden", ""));
    if (line.compare(0, after_method, "GET") != 0) return answer_with(browser, http_answer("405 Method Not Allowed", "Allow: GET\r\n"));
    if (path == "/") return answer_with(browser, document_);
    if (path != "/events") return answer_with(browser, http_answer("404 Not Found", ""));
    const std::string last = header_of(request, "last-event-id");
    if (last.starts_with(story_ + "-")) {
      const auto number = last.substr(story_.size() + 1);
      if (!number.empty() && number.size() < 18 && number.find_first_not_of("0123456789") == std::string::npos)
        browser->next = std::min<std::uint64_t>(std::stoull(number) + 1, end());
    }
    browser->follows = true;
    browser->out =
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nConnection: close\r\nCache-Control: no-store\r\n"
        "X-Content-Type-Options: nosniff\r\n\r\nretry: 1000\n\n";
    write(browser);
    hear(browser);
  }

  void answer_with(const BrowserPointer& browser, const std::string& bytes) {
    browser->out = bytes;
    browser->closes = true;
    browser->since = SteadyClock::now();
    write(browser);
  }

  // Nothing more is expected of a browser that follows: what comes is its end.
  void hear(const BrowserPointer& browser) {
    browser->request.assign(256, ' ');
    browser->socket.async_read_some(asio::buffer(browser->request), [this, browser](const asio::error_code& wrong, std::size_t) {
      wrong ? close(browser) : hear(browser);
    });
  }

  void write(const BrowserPointer& browser) {
    browser->writing = true;
    asio::async_write(browser->socket, asio::buffer(browser->out), [this, browser](const asio::error_code& wrong, std::size_t) {
      browser->writing = false;
      if (wrong || browser->closes)
        close(browser);
      else
        go_on(browser);
    });
  }

  // What is kept and has not been sent, some at once.
  void go_on(const BrowserPointer& browser) {
    if (!browser->follows || browser->writing || browser->next == end()) return;
    browser->out.clear();
    if (browser->next < first_) {
      browser->next = first_;
      if (opening_number_ < first_) browser->out = opening_event_;
    }
    while (browser->next < end() && browser->out.size() < longest_write)
      browser->out += kept_[static_cast<std::size_t>(browser->next++ - first_)];
    write(browser);
  }

  void close(const BrowserPointer& browser) {
    asio::error_code ignored;
    browser->socket.shutdown(tcp::socket::shutdown_both, ignored);
    browser->socket.close(ignored);
    browsers_.erase(browser);
  }

  std::uint64_t end() const { return first_ + kept_.size(); }

  void emit(std::string_view event, const std::string& data) {
    std::string text = "id: " + story_ + "-" + std::to_string(end()) + "\nevent: " + std::string(event) + "\ndata: " + data + "\n\n";
    if (event == opening_) {
      opening_event_ = text;
      opening_number_ = end();
    }
    kept_.push_back(std::move(text));
    if (kept_.size() > most_kept) {
      kept_.pop_front();
      ++first_;
    }
  }

  void look() {
    const bool ends = ended_.load(std::memory_order_acquire);
    next_([this](std::string_view event, const std::string& data) { emit(event, data); });
    if (!accepts_) accept();
    const auto now = SteadyClock::now();
    bool waits = false;
    for (const BrowserPointer& browser : std::vector<BrowserPointer>(browsers_.begin(), browsers_.end())) {
      go_on(browser);
      if (!browser->follows && now - browser->since > longest_question)
        close(browser);
      else
        waits = waits || browser->writing;
    }
    if (ends) {
      if (!farewell_) farewell_ = now;
      if (!waits || now - *farewell_ > longest_farewell) {
        for (const BrowserPointer& browser : std::vector<BrowserPointer>(browsers_.begin(), browsers_.end())) close(browser);
        asio::error_code ignored;
        acceptor_.close(ignored);
        return;
      }
    }
    timer_.expires_after(between_turns);
    timer_.async_wait([this](const asio::error_code& error) {
      if (!error) look();
    });
  }

  int port_;
  asio::io_context context_{1};
  tcp::acceptor acceptor_;
  asio::steady_timer timer_;
  std::string document_, opening_, story_, opening_event_;
  std::function<void(const Emit&)> next_;
  std::set<BrowserPointer> browsers_;
  std::deque<std::string> kept_;
  std::uint64_t first_ = 0, opening_number_ = 0;  // of what is kept
  bool accepts_ = false;
  std::optional<SteadyClock::time_point> farewell_;
  std::atomic<bool> ended_{false};
  std::thread thread_;
};

PageServer::PageServer(int port) : implementation_(std::make_unique<Implementation>(port)) {}
PageServer::~PageServer() = default;
void PageServer::start(std::string document, std::string opening, std::function<void(const Emit&)> next) {
  implementation_->start(std::move(document), std::move(opening), std::move(next));
}

}  // namespace sinew::apps
