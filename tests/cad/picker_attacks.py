"""What is sent to the picker's server in attacks; `{path}` is the secret path of the page, `{host}` its address."""

import json

from cad.session.rows import NEW_COLUMNS

CLOSED = 0  #: No answer at all: the connection was closed.

VERBS = ("GET", "HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "PROPFIND", "get")
METHODS = (*VERBS, "X" * 5000)

PLACES = ("{path}", "{path}save", "{path}keep", "{path}none", "/")

PATHS = (
    "{path}../",
    "{path}../..{path}",
    "/..{path}",
    "/.{path}",
    "/{path}",
    "{path}/",
    "{path}%2e%2e/",
    "{path}..%2f",
    "{path}..%5c",
    "{path}%00",
    "{path}\0",
    "{path}save/",
    "{path}%73ave",
    "{path}save%00",
    "{path}SAVE",
    "{path};x",
    "{path}.git/config",
    "{path}etc/passwd",
    "{path}../../../../etc/passwd",
    "file:///etc/passwd",
    "*",
    "",
    "http://evil.example{path}",
    "http://{host}/",
    "https://{host}{path}",
    "//evil.example{path}",
    "{path}\xe9",
    "\xff\xfe",
    "{path}" + "a/" * 30_000,
    "/" + "a" * 100_000,
    "/%",
    "/%zz",
    "/?{path}",
    "/#{path}",
    "{path} HTTP/1.1\r\nX: 1",
)

HOSTS = (
    *(None, "", "evil.example", "{host}.evil.example", "evil.example:80", "localhost", "LOCALHOST", "127.0.0.1"),
    *("127.0.0.1:0", "127.0.0.1:00080", "127.1", "0x7f.0.0.1", "2130706433", "0.0.0.0", "[::1]", "[::ffff:127.0.0.1]"),
    *("user@{host}", "{host}@evil.example", "{host},evil.example", "{host} evil.example", "{host}.", "{host}/"),
    *("http://{host}", "{host}\r\nHost: x", "\xe4.example", "*", "null", "x" * 60_000),
)

ORIGINS = (
    *(None, "", "null", "http://evil.example", "https://{host}", "http://{host}/", "http://{host}.evil.example"),
    *("HTTP://{host}", "http://user@{host}", "http://127.0.0.1", "http://localhost", "{host}", "//{host}", "file://"),
    *("http://{host} x", "http://{host}, http://evil.example", "http://{host}\r\nOrigin: http://evil.example"),
    *("ws://{host}", "data:", "*", "http://\xe4"),
)

KINDS = (
    *(None, "", "text/plain", "multipart/form-data; boundary=x", "application/x-www-form-urlencoded", "text/json"),
    *("application/jsonp", "application/json, text/plain", "application/ld+json", "json", "*/*", "x" * 60_000),
)

OWN = "POST {path}fit HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Type: application/json\r\n"

HEADS = {
    "20 000 headers": OWN + "X: 1\r\n" * 20_000,
    "a header of 100 kB": OWN + f"X: {'a' * 100_000}\r\n",
    "a header without a colon": OWN + "nonsense\r\n",
    "a folded header": OWN + "X: 1\r\n  Content-Length: 9\r\n",
    "a null in a header": OWN + "X: a\0b\r\n",
    "a return in a header": OWN + "X: a\rb\r\n",
    "an empty name": OWN + ": x\r\n",
    "a space before the colon": OWN + "Content-Length : 2\r\n",
    "two lengths": OWN + "Content-Length: 2\r\nContent-Length: 3\r\n",
    "a length below zero": OWN + "Content-Length: -1\r\n",
    "a length that is text": OWN + "Content-Length: two\r\n",
    "a length with a sign": OWN + "Content-Length: +2\r\n",
    "a length with an underscore": OWN + "Content-Length: 1_0\r\n",
    "a length of 300 digits": OWN + f"Content-Length: {'9' * 300}\r\n",
    "a length of 10 TB": OWN + "Content-Length: 10000000000000\r\n",
    "length and chunks": OWN + "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n",
    "an unknown coding": OWN + "Transfer-Encoding: gzip\r\n",
    "chunks twice": OWN + "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n",
    "an unknown expectation": OWN + "Expect: 200-ok\r\nContent-Length: 2\r\n",
    "WebSocket": "GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n",
    "h2c": "GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: h2c\r\nConnection: Upgrade, HTTP2-Settings\r\n"
    "HTTP2-Settings: AAMAAABkAARAAAAAAAIAAAAA\r\n",
    "HTTP/0.9": "GET {path}",
    "HTTP/2": "PRI * HTTP/2.0\r\n\r\nSM",
    "HTTP/9.9": "GET {path} HTTP/9.9\r\nHost: {host}\r\n",
    "no version": "GET {path} HTTP\r\nHost: {host}\r\n",
    "TLS": "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    "SSH": "SSH-2.0-OpenSSH_9.0\r\n",
    "null bytes": "\0" * 1000,
    "line ends": "\r\n" * 50_000,
    "one long word": "A" * 200_000,
    "only line feeds": "GET {path} HTTP/1.1\nHost: {host}\n",
}

READABLE = (
    "20 000 headers",
    "a header of 100 kB",
    "a folded header",
    "an unknown expectation",
    "WebSocket",
    "h2c",
    "HTTP/9.9",
    "only line feeds",
)
"""The server reads these as HTTP/1.1, and they come from the page's own address."""

BODIES: dict[str, bytes] = {
    "nothing": b"",
    "a word": b"x",
    "half": b'{"revision": 1',
    "two": b"{}{}",
    "a list": b"[]",
    "a number": b"1",
    "null": b"null",
    "text": b'"x"',
    "true": b"true",
    "NaN": b'{"revision": NaN}',
    "infinity": b'{"revision": -Infinity}',
    "a large number": b'{"revision": 1e400}',
    "5000 digits": b'{"revision": ' + b"9" * 5000 + b"}",
    "deep": b"[" * 100_000,
    "deep and closed": b"[" * 50_000 + b"]" * 50_000,
    "deep objects": b'{"a":' * 20_000 + b"1" + b"}" * 20_000,
    "a name twice": b'{"revision": 1, "revision": "x"}',
    "true for one": b'{"revision": true, "window": "w", "number": 1}',
    "1.0 for one": b'{"revision": 1.0}',
    "UTF-16": '{"revision": 1}'.encode("utf-16"),
    "Latin-1": b'{"window": "\xe9"}',
    "half a pair": b'{"window": "\\ud800"}',
    "null in text": b'{"revision": 1, "window": "\\u0000", "number": 1}',
    "BOM": b"\xef\xbb\xbf{}",
    "a comment": b"/* */ {}",
    "XML": b'<?xml version="1.0"?><!DOCTYPE x SYSTEM "file:///etc/passwd"><x/>',
    "a form": b"revision=1&window=w",
    "zip": b"PK\x03\x04" + b"\0" * 100,
    "a prototype": b'{"__proto__": {"revision": 1}, "constructor": 1}',
    "many rows": json.dumps({"columns": list(NEW_COLUMNS), "rows": [["V2"] * 6] * 20_000}).encode(),
    "many columns": json.dumps({"columns": ["x"] * 50_000, "rows": []}).encode(),
    "a long cell": json.dumps(
        {"columns": list(NEW_COLUMNS), "rows": [["V" * 1_000_000, "1", "2", "3", "V2", "yes"]]}
    ).encode(),
    "words for rows": b'{"columns": 1, "rows": 2}',
    "cells without columns": b'{"columns": [], "rows": [[]]}',
    "a key without a row": b'{"revision": 1, "window": "w", "number": 0, "table": {"columns": [], "keys": ["a"]}}',
    "a number for a name": b'{"revision": 1, "name": 3, "solid": 3}',
    "an empty candidate": b'{"revision": "1", "decisions": [{"candidate": {}, "edit": {}}]}',
    "a formula": json.dumps(
        {"columns": list(NEW_COLUMNS), "rows": [["=cmd|x!A1", "=1", "+2", "@3", "V2", "yes"]]}
    ).encode(),
    "nested cells": json.dumps({"columns": list(NEW_COLUMNS), "rows": [[["V2"], {}, None, 3, True, "yes"]]}).encode(),
}
"""For every action."""

NAMES = (
    "../x.csv",
    "/tmp/day-x.csv",
    "a/b.csv",
    "..",
    ".",
    "x\0.csv",
    "x\n.csv",
    "x" * 300 + ".csv",
    "taught.csv.draft",
    "taught.csv.bak",
    "~/x.csv",
    "..\\x.csv",
    "C:\\x.csv",
    "\u202ecsv.x/",
    "%2e%2e/x.csv/..",
    "x.csv/",
)
