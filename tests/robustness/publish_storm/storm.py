# SPDX-License-Identifier: Apache-2.0
"""Interleavings in several places at a time, and the kills among them."""
import collections
import random
import threading
import time
import traceback

from . import actions, breakage, calls, ledger, oracle, places

LIFE = 4  # interleavings of a place
MAPPED, FAILED = 3, 4  # states of a session
PATIENCE_S = 120


class Tally:
    """Counts what happened, and what must not have. Thread-safe."""

    def __init__(self):
        self.lock = threading.Lock()
        self.counts = collections.Counter()
        self.failures = []

    def add(self, what, count=1):
        with self.lock:
            self.counts[what] += count

    def guard(self, number, action, *arguments):
        """Does a part of an interleaving; its end by an error is a failure."""
        try:
            action(*arguments)
        except Exception as error:  # pylint: disable=broad-except  # a thread's end would go unnoticed
            if not isinstance(error, calls.Fault):
                traceback.print_exc()
            with self.lock:
                self.failures.append(f"interleaving {number}: {type(error).__name__}: {error}")


class Lane:
    """One place after the other."""

    def __init__(self, call, tally, seed, number):
        self.call, self.tally, self.seed, self.number = call, tally, seed, number
        self.place, self.oracle = None, None

    def prepare(self, interleaving):
        """A new place, unless the old one is still good."""
        if self.place and not self.place.deleted and self.place.interleavings < LIFE:
            return
        rng = random.Random(f"{self.seed}-{interleaving}-place")
        site = f"p{interleaving}"
        if self.place and self.place.deleted and rng.random() < 0.6:
            site = self.place.site.split("/")[1]  # a map of the same name, whose drafts have the same names, too
            self.tally.add("maps_made_again")
        else:
            self.leave()
            self.call.sure("SiteService.CreateSite", site_id=site, request_id=site, site={"display_name": site})
            self.call.sure("RobotService.CreateRobot", parent=f"sites/{site}", robot_id="r", request_id=f"{site}-r",
                           robot={"display_name": "r"})
            self.create_map(site, "n", interleaving)
        self.place = place = ledger.Place(site, rng)
        self.oracle = oracle.Oracle(self.call, place, self.tally)
        self.create_map(site, place.map_id, interleaving)
        self.join(interleaving)
        acts = actions.Actions(self.call, place, f"{interleaving}-first", self.seed, self.tally)
        if place.begins_with_file:
            acts.import_file()
        else:
            acts.drive()
            self.await_revision()

    def create_map(self, site, name, interleaving):
        self.call.sure("MapService.CreateMap", parent=f"sites/{site}", map_id=name, request_id=f"{site}-{name}-{interleaving}",
                       map={"display_name": name, "environment": places.INDOOR})

    def join(self, interleaving):
        """The map with its neighbour, so that there is something to optimise."""
        site = self.place.site
        anchors = [{"map": name, "pose_map_place": {"pose": {"x": x}, "covariance": actions.COVARIANCE}}
                   for name, x in ((self.place.name, 5), (f"{site}/maps/n", 1))]
        self.call.sure("LinkPointService.CreateLinkPoint", parent=site, link_point_id="d",
                       request_id=f"{site}-d-{interleaving}", link_point={"kind": 1, "anchors": anchors})

    def await_revision(self):
        give_up = time.monotonic() + PATIENCE_S
        while not self.call.sure("MapService.GetMap", name=self.place.name).map.latest_revision:
            if time.monotonic() > give_up:
                raise calls.Fault(f"{self.place.name} has no revision after {PATIENCE_S} s")
            time.sleep(0.03)

    def interleave(self, number):
        """One publish, and what goes on at the same time."""
        place = self.place
        place.interleavings += 1
        rng = random.Random(f"{self.seed}-{number}")
        acts = actions.Actions(self.call, place, number, self.seed, self.tally)
        first, second = (f"d{place.interleavings}-{which}" for which in (1, 2))
        chosen = [(acts.publish_draft, first)]
        if rng.random() < 0.55:
            chosen.append((acts.publish_draft, second, first if rng.random() < 0.2 else None))
        chosen += [(action,) for action, share in ((acts.drive, 0.7), (acts.import_file, 0.3), (acts.optimise, 0.4),
                                                      (acts.restore, 0.08))
                   if rng.random() < share]
        # The last of a place's interleavings ends in its deletion, often enough.
        if rng.random() < (0.3 if place.interleavings == LIFE else 0.04):
            chosen.append((acts.delete,))
        threads = [threading.Thread(target=self.tally.guard, args=(number, *action)) for action in chosen]
        rng.shuffle(threads)
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    def check(self):
        self.oracle.check()

    def leave(self):
        """At the end of a place: its sessions are mapped, and all still holds."""
        if not self.place:
            return
        if not self.place.deleted:
            self.await_mapped()
            for draft in self.place.drafts.values():
                draft.drawn = None
            self.oracle.check()
        self.call.sure("SiteService.DeleteSite", name=self.place.site, force=True)
        self.place = None

    def await_mapped(self):
        give_up = time.monotonic() + PATIENCE_S
        for name in self.place.sessions:
            while True:
                session = self.call.sure("SessionService.GetSession", name=name).session
                if session.state == FAILED:
                    raise calls.Fault(f"{name} has failed: {session.error}")
                if session.state == MAPPED:
                    break
                if time.monotonic() > give_up:
                    raise calls.Fault(f"{name} is not mapped after {PATIENCE_S} s")
                time.sleep(0.05)


class Killer:
    """kill -9 of the server, now and then of the database as well, while a round is under way."""

    def __init__(self, running, call, tally):
        self.running, self.call, self.tally = running, call, tally

    def strike(self, rng, is_over):
        for _ in range(rng.choice((1, 1, 1, 2))):
            if rng.random() < 0.6:
                self.call.publishing.clear()
                self.call.publishing.wait(0.6)
                time.sleep(rng.uniform(0, 0.06))
            else:
                time.sleep(rng.uniform(0, 0.5))
            self.call.up.clear()
            with_database = rng.random() < 0.12
            self.tally.add("kills_amid_interleavings", 0 if is_over() else 1)
            if with_database:
                self.running.kill_database()
                self.tally.add("kills_of_the_database")
                time.sleep(rng.choice((0, rng.uniform(0, 0.2))))
            self.running.kill_server()
            self.tally.add("kills_of_the_server")
            if with_database:
                self.running.start_database()
            self.running.start_server()
            self.call.api.connect()
            self.call.up.set()


class Storm:
    """All lanes, round by round."""

    def __init__(self, running, call, seed, lanes):
        self.tally = Tally()
        self.running, self.seed = running, seed
        self.killer = Killer(running, call, self.tally)
        self.lanes = [Lane(call, self.tally, seed, number) for number in range(lanes)]
        self.done = self.rounds = 0

    def for_lanes(self, lanes, action):
        """Does it in each lane, of which it gets the number of the interleaving. Gives the threads."""
        threads = [threading.Thread(target=self.tally.guard, args=(number, action, lane, number)) for number, lane in lanes]
        for thread in threads:
            thread.start()
        return threads

    def round(self, count):
        """So many interleavings at one time, at most one in each lane; then they are checked."""
        numbered = [(self.done + i, lane) for i, lane in enumerate(self.lanes[:count])]
        self.settle(self.for_lanes(numbered, lambda lane, number: lane.prepare(number)))
        if self.tally.failures:
            return
        rng = random.Random(f"{self.seed}-{self.done}-kill")
        threads = self.for_lanes(numbered, lambda lane, number: lane.interleave(number))
        if self.rounds % 2 == 0:
            self.tally.add("interleavings_with_kills", count)
            self.tally.guard(self.done, self.killer.strike, rng, lambda: not any(thread.is_alive() for thread in threads))
        self.settle(threads)
        self.settle(self.for_lanes(numbered, lambda lane, _: lane.check()))
        self.done += count
        self.rounds += 1

    @staticmethod
    def settle(threads):
        for thread in threads:
            thread.join()

    def prove(self):
        """That what is broken is found."""
        quiet = Tally()
        missed = breakage.unnoticed(self.running.url, lambda: Lane(self.lanes[0].call, quiet, self.seed, 0))
        self.tally.failures += quiet.failures
        self.tally.failures += [f"nobody has noticed: {what}" for what in missed]
        self.tally.add("breakages_found", len(breakage.WAYS) - len(missed))

    def finish(self):
        self.settle(self.for_lanes([(self.done, lane) for lane in self.lanes if lane.place],
                                   lambda lane, _: lane.leave()))
