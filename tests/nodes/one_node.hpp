#pragma once

// Runs a single node, as a graph would.

#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"

#include <map>
#include <stdexcept>

namespace fixtures {

// Runs one node on the values of its inputs by name, with parameters changed by name.
struct NodeRun {
    const graph::NodeType& type;
    std::map<std::string, std::vector<graph::Value>> inputs;
    graph::ParamValues params;
    std::vector<graph::Value> previous;
    graph::FrameRange range{1, 10, 24};
    double pace = 0;            // s of the scene a frame; 0: as of the video
    std::vector<int> gathered;  // of gathered inputs; empty: those that the node asks for
    std::filesystem::path output_folder = ".";
    std::shared_ptr<graph::Cook> cook;
    std::stop_token stop;
    std::vector<std::string> warnings;
    graph::Figures told;

    explicit NodeRun(const std::string& name)
        : type(*nodes::registry().find(name)), previous(type.previous.size())
    {
        for (const auto& p : type.params) params.push_back(p.fallback);
    }

    // "a" or "block.a".
    graph::ParamValue& param(const std::string& path) { return find(type.params, params, path); }

    // The first output.
    graph::Value run(int frame = 1) { return outputs(frame).at(0); }

    std::vector<graph::Value> outputs(int frame = 1)
    {
        std::vector<std::vector<graph::Value>> by_port;
        for (const auto& port : type.inputs) by_port.push_back(inputs[port.name]);
        graph::Context context(frame, range, type.reads, pace);
        context.output_folder = output_folder;
        context.cook = cook;
        context.stop = stop;
        context.gathered = gathered;
        if (gathered.empty() && type.gather_frames) {
            context.gathered = type.gather_frames(params, range);
        }
        context.warn = [this](const std::string& text) { warnings.push_back(text); };
        context.tell = [this](graph::Figures figures) { told = std::move(figures); };
        std::vector<std::shared_ptr<const void>> prepared;
        for (const auto& p : type.preparations) {
            prepared.push_back(p.build({by_port, params, {}, {}, context}));
        }
        return type.run({by_port, params, previous, prepared, context});
    }

private:
    static graph::ParamValue& find(const std::vector<graph::Param>& all, graph::ParamValues& values,
                                   const std::string& path)
    {
        const auto dot = path.find('.');
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (all[i].name != path.substr(0, dot)) continue;
            if (dot == std::string::npos) return values[i];
            return find(all[i].children, std::get<graph::ParamValues>(values[i].is),
                        path.substr(dot + 1));
        }
        throw std::logic_error("no parameter " + path);
    }
};

}  // namespace fixtures
