"""One door for all episodes, over streets as over cells and regions: to files, and to pictures."""

from __future__ import annotations

from pathlib import Path

from sooner.io.arrays import has_array
from sooner.simulation import episode_file
from sooner.simulation.episode import Episode
from sooner.simulation.plan_episode import PlanEpisode
from sooner.simulation.plan_episode_file import load_plan_episode, plan_episode_npz

__all__ = ["AnyEpisode", "animation_of", "load_episode", "picture_of", "save_episode"]

AnyEpisode = Episode | PlanEpisode

FRAMES = 60  # of an animation
LEAST_FRAME_S = 4  # over streets


def save_episode(episode: AnyEpisode, path: Path) -> None:
    """Write an episode.

    Raises
    ------
    InvalidProblemError      where targets walk by a function of your own: no file can hold it
    """
    if isinstance(episode, PlanEpisode):
        path.write_bytes(plan_episode_npz(episode))
    else:
        episode_file.save_episode(episode, path)


def load_episode(path: Path) -> AnyEpisode:
    """Read an episode, of whichever kind.

    Raises
    ------
    DataFormatError          missing, too large, no episode, or one that contradicts itself
    """
    return load_plan_episode(path) if has_array(path, "truth") else episode_file.load_episode(path)


def picture_of(episode: AnyEpisode) -> bytes:
    """PNG: what was known and flown in each quarter of the time, and how what was found grew."""
    from sooner.simulation.picture import picture_of
    from sooner.simulation.plan_picture import plan_episode_picture

    return plan_episode_picture(episode) if isinstance(episode, PlanEpisode) else picture_of(episode)


def animation_of(episode: AnyEpisode) -> bytes:
    """GIF: what is known and flown, in about sixty frames."""
    from sooner.simulation.picture import animation_of
    from sooner.simulation.plan_picture import animated_plan

    if isinstance(episode, PlanEpisode):
        return animated_plan(episode, FRAMES)
    return animation_of(episode, max(LEAST_FRAME_S, -(-episode.seconds // FRAMES)))
