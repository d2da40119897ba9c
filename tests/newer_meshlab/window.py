"""window.py MESHLAB CLOUD MESH PICTURES: what a person does in MeshLab's window, on the display that is there.

Opens a cloud, applies the filter with its defaults from the Filters menu, and exports the new layer to MESH. Every widget
is found by its name, through the interface that Qt offers to screen readers, and gets real clicks and keys where it lies.
Fails unless the list of layers shows the new layer and the file is there; leaves pictures of every step.

Needs a session bus (dbus-run-session), at-spi2-core, python3-gi, openbox, xdotool, ImageMagick."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time

from gi.repository import Gio, GLib

MENU = "Remeshing, Simplification and Reconstruction"
FILTER = "Surface Reconstruction: Shrink Wrap"
LAYER_SUFFIX = " shrink wrap"
SHOWING = 1 << 25  # of the states of a widget


class Failure(Exception):
    pass


def run(*command):
    return subprocess.run(command, capture_output=True, check=True, text=True).stdout


def call(bus, name, path, method, arguments=None):
    """Calls a method (interface.name) on a bus; what it returns."""
    interface, method = method.rsplit(".", 1)
    return bus.call_sync(name, path, interface, method, arguments, None, Gio.DBusCallFlags.NONE, 20000, None).unpack()


class Widget:
    """A widget of a program, as the program tells it to a screen reader. Raises GLib.Error once it is gone."""

    def __init__(self, bus, program, path):
        self.bus, self.program, self.path = bus, program, path

    def ask(self, method, arguments=None):
        return call(self.bus, self.program, self.path, method, arguments)

    def name(self):
        arguments = GLib.Variant("(ss)", ("org.a11y.atspi.Accessible", "Name"))
        return self.ask("org.freedesktop.DBus.Properties.Get", arguments)[0]

    def role(self):
        return self.ask("org.a11y.atspi.Accessible.GetRoleName")[0]

    def is_showing(self):
        return bool(self.ask("org.a11y.atspi.Accessible.GetState")[0][0] & SHOWING)

    def middle(self):
        (x, y, width, height), = self.ask("org.a11y.atspi.Component.GetExtents", GLib.Variant("(u)", (0,)))
        return x + width // 2, y + height // 2

    def children(self):
        return [Widget(self.bus, program, path) for program, path in self.ask("org.a11y.atspi.Accessible.GetChildren")[0]]

    def below(self):
        """All widgets below this one that show on the screen, but those that vanish meanwhile."""
        try:
            for child in self.children():
                if child.is_showing():
                    yield child
                    yield from child.below()
        except GLib.Error:
            return


class MeshLab:
    """The program as a person sees it."""

    def __init__(self, program, cloud, pictures, home):
        self.pictures = pictures
        self.log = home / "host.log"
        session = Gio.bus_get_sync(Gio.BusType.SESSION)
        address, = call(session, "org.a11y.Bus", "/org/a11y/bus", "org.a11y.Bus.GetAddress")
        call(session, "org.a11y.Bus", "/org/a11y/bus", "org.freedesktop.DBus.Properties.Set",
             GLib.Variant("(ssv)", ("org.a11y.Status", "IsEnabled", GLib.Variant("b", True))))
        flags = Gio.DBusConnectionFlags.AUTHENTICATION_CLIENT | Gio.DBusConnectionFlags.MESSAGE_BUS_CONNECTION
        self.bus = Gio.DBusConnection.new_for_address_sync(address, flags, None, None)
        environment = dict(os.environ, HOME=str(home), XDG_RUNTIME_DIR=str(home), LIBGL_ALWAYS_SOFTWARE="1",
                           QT_LINUX_ACCESSIBILITY_ALWAYS_ON="1")
        self.processes = []
        with open(self.log, "w", encoding="utf-8") as log:
            for command in (["openbox"], [program, cloud]):
                self.processes.append(subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT))

    def close(self):
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def picture(self, name):
        run("import", "-window", "root", str(self.pictures / f"{name}.png"))

    def wait_for(self, what, condition, seconds=240):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.processes[-1].poll() is not None:
                raise Failure(f"MeshLab ended before {what}")
            try:
                result = condition()
            except GLib.Error:  # a widget that was there a moment ago
                result = None
            if result:
                return result
            time.sleep(0.3)
        raise Failure(f"waited in vain for {what}")

    def root(self):
        """The program's own node among all that offer the interface; None while there is none."""
        def ask(method, *names):
            arguments = GLib.Variant("(s)", names) if names else None
            return call(self.bus, "org.freedesktop.DBus", "/org/freedesktop/DBus", f"org.freedesktop.DBus.{method}", arguments)[0]
        try:
            for name in ask("ListNames"):
                if name.startswith(":") and ask("GetConnectionUnixProcessID", name) == self.processes[-1].pid:
                    return Widget(self.bus, name, "/org/a11y/atspi/accessible/root")
        except GLib.Error:
            pass  # one of them has just left
        return None

    def showing(self, roles, name=None, within=None):
        """The widgets of these roles, and of this name, that show on the screen."""
        parent = within or self.root()
        found = []
        for widget in parent.below() if parent else []:
            try:
                if widget.role() in roles and name in (None, widget.name()):
                    found.append(widget)
            except GLib.Error:
                continue
        return found

    def widget(self, name, *roles, within=None):
        """The widget of this name, once it shows and lies still."""
        def still():
            found = self.showing(roles, name, within)
            if not found:
                return None
            before = found[0].middle()
            time.sleep(0.5)
            return found[0] if found[0].middle() == before else None
        return self.wait_for(f'the {roles[0]} "{name}"', still)

    def click(self, widget):
        run("xdotool", "mousemove", *map(str, widget.middle()), "sleep", "0.3", "click", "1")
        time.sleep(1)

    def layers(self):
        """The labels in the list of layers; a star marks one that is not saved."""
        cells = [widget.name() for widget in self.showing(("tree item",))]
        return [name for name in cells if name and not name.isdigit()]


def reconstruct_and_export(host, cloud, mesh):
    name = pathlib.Path(cloud).stem
    host.wait_for("the cloud to be opened", lambda: "All files opened" in host.log.read_text(errors="replace"))
    host.wait_for("the cloud's layer", lambda: host.layers() == [name])
    window = run("xdotool", "search", "--onlyvisible", "--name", "^MeshLab [0-9]").split()[-1]
    run("xdotool", "windowactivate", "--sync", window, "windowsize", window, "1400", "930", "windowmove", window, "0", "0")
    time.sleep(3)
    host.picture("opened")

    for entry in ("Filters", MENU, FILTER):
        host.click(host.widget(entry, "menu item"))
    dialog = host.widget(FILTER, "frame", "dialog")
    host.picture("dialog")
    host.click(host.widget("Apply", "push button", within=dialog))
    made = name + LAYER_SUFFIX
    host.wait_for(f'the layers "{name}" and "{made}"', lambda: host.layers() in ([name, made], [name, made + " *"]))
    host.click(host.widget("Close", "push button", within=dialog))
    host.picture("result")

    for entry in ("File", "Export Mesh As..."):
        host.click(host.widget(entry, "menu item"))
    host.click(host.widget("File name:", "text"))
    run("xdotool", "key", "ctrl+a")
    run("xdotool", "type", "--delay", "60", mesh)
    host.picture("export")
    host.click(host.widget("Save", "push button"))
    host.click(host.widget("OK", "push button"))
    host.wait_for(f"the file {mesh}", lambda: os.path.exists(mesh) and os.path.getsize(mesh) > 0)
    host.wait_for("the layer to be saved", lambda: len(host.layers()) == 2 and not host.layers()[1].endswith("*"))
    host.picture("exported")
    print(f"the window shows the layers {host.layers()}")


def main():
    program, cloud, mesh, pictures = sys.argv[1:5]
    with tempfile.TemporaryDirectory() as home:
        host = MeshLab(program, cloud, pathlib.Path(pictures), pathlib.Path(home))
        try:
            reconstruct_and_export(host, cloud, mesh)
        except Failure as failure:
            host.picture("stuck")
            shown = [f'{widget.role()} "{widget.name()}"' for widget in host.root().below()] if host.root() else []
            print(f"{host.log.read_text(errors='replace')}\nwindow.py: there are: {', '.join(shown)}", file=sys.stderr)
            sys.exit(f"window.py: {failure}")
        finally:
            host.close()


if __name__ == "__main__":
    main()
